#pragma once
/// The report page's style sheet and its one script. Both stand inside the page.

namespace procam::report {

/// One accent colour; light and dark follow the reader's system, and paper is always light.
inline constexpr char kReportStyle[] = R"css(
:root { color-scheme: light dark; --page: #fbfbfa; --card: #fff; --ink: #1d2327; --soft: #5d6870;
  --line: #d9dde0; --accent: #0b6e99; --good: #1c7a44; --bad: #c02f1d; --warn: #9a6700; --tint: #0b6e9914; --shade: #0000002e; }
@media screen and (prefers-color-scheme: dark) {
  :root { --page: #14181b; --card: #1b2125; --ink: #e4e8ea; --soft: #9ba7ae; --line: #363f45;
    --accent: #58b4dc; --good: #5cc689; --bad: #ff7d6b; --warn: #e0b050; --tint: #58b4dc1c; --shade: #000000b0; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1120px; padding: 32px 24px 64px; background: var(--page); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", "DejaVu Sans", sans-serif; }
h1 { font-size: 26px; line-height: 1.2; margin: 0 0 20px; overflow-wrap: anywhere; }
h2 { font-size: 19px; margin: 44px 0 4px; padding-top: 12px; border-top: 1px solid var(--line); }
h3 { font-size: 15px; margin: 20px 0 4px; overflow-wrap: anywhere; }
p { margin: 4px 0 12px; max-width: 95ch; }
.kicker { color: var(--accent); font-weight: 600; margin: 0; }
.hint, figcaption { color: var(--soft); font-size: 13px; }
.pair + .scroll { margin-top: 20px; } .scroll + .hint { margin-top: 8px; }
.verdict { border-left: 6px solid var(--good); background: var(--card); padding: 14px 18px; }
.verdict.failed { border-color: var(--bad); } .verdict.imprecise { border-color: var(--warn); }
.verdict p { margin: 0; font-size: 17px; max-width: none; }
.verdict ul { margin: 8px 0 0; padding-left: 20px; }
.pass { color: var(--good); } .fail { color: var(--bad); font-weight: 600; } .warning { color: var(--warn); }
.pass, .warning, .note { white-space: nowrap; } p.warning { white-space: normal; }
.key { display: grid; grid-template-columns: repeat(auto-fit, minmax(170px, 1fr)); gap: 12px; margin: 16px 0; }
.key div { background: var(--card); border: 1px solid var(--line); border-radius: 6px; padding: 10px 14px; }
.key b { display: block; font-size: 22px; font-weight: 600; font-variant-numeric: tabular-nums; }
.key span { color: var(--soft); font-size: 13px; display: block; line-height: 1.35; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 8px 32px;
  align-items: start; }
.tiles { display: grid; grid-template-columns: repeat(auto-fill, minmax(230px, 1fr)); gap: 8px 16px; }
.contents { display: flex; flex-wrap: wrap; gap: 6px 18px; margin: 20px 0 0; font-size: 13px; }
.contents a { color: var(--accent); text-decoration: none; } .contents a:hover { text-decoration: underline; }
section { scroll-margin-top: 12px; }
/* Shadows at the edges where a table goes on; the page's script adds words. */
.captures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(320px, 100%), 1fr)); gap: 8px 16px; }
.scroll { overflow-x: auto; background:
  linear-gradient(to right, var(--page) 40%, transparent) left / 32px 100% no-repeat local,
  linear-gradient(to left, var(--page) 40%, transparent) right / 32px 100% no-repeat local,
  linear-gradient(to right, var(--shade), transparent) left / 12px 100% no-repeat,
  linear-gradient(to left, var(--shade), transparent) right / 12px 100% no-repeat; }
.scroll.more::before { content: "Scroll sideways \2192"; position: sticky; left: 0; display: block; width: max-content;
  color: var(--accent); font-size: 12px; }
table { border-collapse: collapse; width: 100%; font-size: 14px; }
th { text-align: left; font-weight: 600; color: var(--soft); font-size: 13px; vertical-align: bottom; }
th, td { padding: 4px 10px 4px 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td { overflow-wrap: break-word; }
details td { overflow-wrap: anywhere; }
.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; overflow-wrap: normal; }
th.n + th:not(.n), td.n + td:not(.n) { padding-left: 10px; }
.u { color: var(--soft); white-space: nowrap; }
.mono { font: 12px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; }
.swatch { display: inline-block; width: 10px; height: 10px; border-radius: 50%; margin-right: 8px; }
figure { margin: 8px 0 0; min-width: 0; }
figcaption { margin-top: 4px; overflow-wrap: anywhere; max-width: 95ch; }
.matrix { max-width: 820px; } .matrix svg { min-width: 520px; }
figcaption b { color: var(--ink); }
svg { display: block; width: 100%; height: auto; background: var(--card); border-radius: 6px; }
/* Colours of views are attributes, which any rule of a style sheet overrides: none here may set them. */
svg path:not([fill]), svg rect, svg circle { fill: none; }
svg ellipse { fill: none; }
svg path, svg rect, svg circle, svg ellipse { vector-effect: non-scaling-stroke; }
svg .frame { stroke: var(--soft); stroke-width: 1px; }
svg .axis { stroke: var(--line); stroke-width: 1px; }
svg .ring { stroke: var(--accent); stroke-width: 1.2px; stroke-dasharray: 5 3; }
svg .tick { fill: var(--soft); font-family: inherit; }
svg .tick:not([font-size]) { font-size: 11px; }
svg .halo { paint-order: stroke; stroke: var(--card); stroke-width: 3px; stroke-linejoin: round;
  vector-effect: non-scaling-stroke; }
svg .dots, svg .feet { stroke-linecap: round; stroke-width: 4px; stroke-opacity: .8; }
svg .feet { stroke-width: 2.5px; stroke-opacity: 1; }
svg .quiver { stroke-width: 1.2px; }
svg .out { stroke: var(--bad); stroke-width: 1.8px; }
svg .out.thin { stroke-width: 1px; stroke-dasharray: 3 2; }
svg .unused { stroke: var(--soft); stroke-width: 1px; }
svg .empty { fill: var(--tint); }
/* On colours that are the same in light and dark. */
svg .over { stroke: #14181b; stroke-width: 1.6px; } svg .under { stroke: #fff; stroke-width: 4px; stroke-opacity: .6; }
svg .on-heat { fill: #14181b; } svg .on-heat.dark { fill: #fff; }
svg .principal { stroke: var(--accent); stroke-width: 1.8px; }
svg .accent { fill: var(--accent); }
svg path.held { fill: var(--line); } svg path.held.taken { fill: var(--accent); }
svg path.rms { fill: var(--soft); fill-opacity: .55; }
svg path.rms.warn { fill: var(--warn); fill-opacity: 1; } svg path.rms.bad { fill: var(--bad); fill-opacity: 1; }
svg .tick.warn { fill: var(--warn); } svg .tick.bad { fill: var(--bad); }
svg path.lens { stroke: var(--accent); stroke-width: 1.2px; stroke-opacity: .6; }
svg .arrow { stroke: var(--ink); stroke-width: 1.2px; stroke-linecap: round; }
/* On photographs, the same in light and dark. */
svg .found { stroke: #19c3ff; stroke-width: 1.2px; } svg .projection { stroke: #ffe14d; stroke-width: 2px; stroke-linecap: round; }
svg .light-point { stroke: #ff9f1c; stroke-width: 3px; stroke-linecap: round; } svg .rejected { stroke: #ff3b30; stroke-width: 2px; }
svg .bar { stroke: var(--ink); stroke-width: 2px; }
svg path.sheet { fill: var(--card); fill-opacity: .6; stroke-width: 1.2px; }
svg .next, svg path.sheet.next { stroke: var(--accent); stroke-width: 2px; stroke-dasharray: 7 4; fill: none; }
svg path.dark { fill-opacity: .7; }
svg path.ray { stroke-width: 1px; stroke-opacity: .5; stroke-dasharray: 6 4; }
svg path.body { stroke-width: 1.6px; stroke-linejoin: round; }
svg path.sight { stroke: var(--ink); } svg path.light { stroke: var(--accent); }
svg path.body.sight { fill: var(--ink); fill-opacity: .12; } svg path.body.light { fill: var(--accent); fill-opacity: .18; }
svg text.sight { fill: var(--ink); font-size: 13px; } svg text.light { fill: var(--accent); font-size: 13px; }
svg .axis-x { stroke: #c8402f; stroke-width: 2.5px; } svg .axis-y { stroke: #3a8f4d; stroke-width: 2.5px; }
svg .axis-z { stroke: #3b6fd4; stroke-width: 2.5px; }
#rig.turning { cursor: grabbing; } #rig.ready { cursor: grab; touch-action: none; }
#rig:focus-visible { outline: 2px solid var(--accent); }
@media (max-width: 600px) { body { padding: 20px 16px 48px; } h1 { font-size: 22px; }
  .key { grid-template-columns: repeat(2, 1fr); } .tiles { grid-template-columns: repeat(auto-fill, minmax(150px, 1fr)); }
  .scroll table { width: max-content; min-width: 100%; } td { max-width: 62vw; } }
@media print { .contents, .scroll.more::before { display: none; } .scroll { overflow: visible; background: none; }
  body { max-width: none; padding: 0; font-size: 11pt; } h2 { break-after: avoid; }
  figure, tr, .verdict, .key div { break-inside: avoid; }
  * { -webkit-print-color-adjust: exact; print-color-adjust: exact; } }
)css";

/// Turns the picture of the rig by dragging or with the arrow keys (Home: as drawn), marks tables that scroll, and opens
/// the list of files for printing. The equations and the fit are Viewpoint's of report_scene.cpp.
inline constexpr char kReportScript[] = R"js(
(() => {
  addEventListener('beforeprint', () => document.querySelectorAll('details').forEach(d => d.open = true));
  const mark = () => document.querySelectorAll('.scroll').forEach(
    s => s.classList.toggle('more', s.scrollWidth > s.clientWidth + 1));
  mark();
  addEventListener('resize', mark);
  document.querySelectorAll('details').forEach(d => d.addEventListener('toggle', mark));
  const svg = document.getElementById('rig');
  if (!svg) return;
  const [yaw0, pitch0, cx, cy, cz, width, height, margin, bar] = svg.dataset.view.split(' ').map(Number);
  const shapes = [...svg.querySelectorAll('[data-p]')].map(node => ({
    node, text: node.tagName === 'text', end: node.dataset.closed ? 'Z' : '',
    fitted: node.matches('.sheet, .body, [class^=axis-]'), flat: [],
    lines: node.dataset.p.split(';').map(line => line.split(' ').map(Number)) }));
  const boards = [...svg.querySelectorAll('.board')].map(node => ({
    node, at: node.firstElementChild.dataset.p.split(' ').map(Number) }));
  const scaleBar = svg.querySelector('.bar'), barWords = svg.querySelector('.bar + text');
  let yaw = yaw0, pitch = pitch0;
  const draw = () => {
    const a = Math.cos(yaw), b = Math.sin(yaw), c = Math.cos(pitch), d = Math.sin(pitch);
    let left = Infinity, right = -Infinity, top = Infinity, bottom = -Infinity;
    for (const shape of shapes)
      shape.flat = shape.lines.map(line => {
        const flat = [];
        for (let i = 0; i < line.length; i += 3) {
          const x = line[i] - cx, y = line[i + 1] - cy, z = line[i + 2] - cz;
          const u = a * x - b * z, v = c * y - d * (b * x + a * z);
          flat.push([u, v]);
          if (!shape.fitted) continue;
          left = Math.min(left, u);
          right = Math.max(right, u);
          top = Math.min(top, v);
          bottom = Math.max(bottom, v);
        }
        return flat;
      });
    const scale = Math.min((width - 2 * margin) / (right - left), (height - 2 * margin) / (bottom - top));
    const at = ([u, v]) => [(width + scale * (2 * u - left - right)) / 2,
                            (height + scale * (2 * v - top - bottom)) / 2].map(n => n.toFixed(1));
    for (const { node, text, end, flat } of shapes) {
      if (text) {
        const [x, y] = at(flat[0][0]);
        node.setAttribute('x', x);
        node.setAttribute('y', y);
      } else {
        node.setAttribute('d', flat.map(line => 'M' + line.map(p => at(p).join(' ')).join('L') + end).join(''));
      }
    }
    const barEnd = margin / 2 + scale * bar;
    scaleBar.setAttribute('d', `M${margin / 2} ${barWords.getAttribute('y')}H${barEnd.toFixed(1)}`);
    barWords.setAttribute('x', (barEnd + 8).toFixed(1));
    const depth = ({ at: [x, y, z] }) => c * (b * x + a * z) + d * y;
    boards.sort((p, q) => depth(p) - depth(q)).forEach(board => svg.prepend(board.node));
  };
  const turn = (dx, dy) => {
    yaw += 0.008 * dx;
    pitch = Math.max(-1.57, Math.min(1.57, pitch + 0.008 * dy));
    draw();
  };
  const reset = () => { yaw = yaw0; pitch = pitch0; draw(); };
  let last = null;
  svg.addEventListener('pointerdown', e => {
    last = [e.clientX, e.clientY];
    svg.setPointerCapture(e.pointerId);
    svg.classList.add('turning');
  });
  svg.addEventListener('pointermove', e => {
    if (!last) return;
    turn(e.clientX - last[0], e.clientY - last[1]);
    last = [e.clientX, e.clientY];
  });
  for (const name of ['pointerup', 'pointercancel'])
    svg.addEventListener(name, () => { last = null; svg.classList.remove('turning'); });
  svg.addEventListener('dblclick', reset);
  svg.addEventListener('keydown', e => {
    const step = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] }[e.key];
    if (step) turn(...step); else if (e.key === 'Home') reset(); else return;
    e.preventDefault();
  });
  svg.classList.add('ready');
  document.getElementById('turn').textContent =
    'Drag to turn (or use the arrow keys); a double click brings the first view back.';
})();
)js";

}  // namespace procam::report
