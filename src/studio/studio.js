"use strict";
const $ = id => document.getElementById(id);
const token = new URLSearchParams(location.search).get("token") || "";
const svgns = "http://www.w3.org/2000/svg";
const titles = { display: "Display", camera: "Camera", board: "Board", capture: "Capture", calibrate: "Calibrate",
  surfaces: "Surfaces", content: "Content", show: "Show" };
const boards = {
  a4: ["charuco:5x7:34mm:25mm:5x5_100", "chessboard:8x5:24mm"], letter: ["charuco:5x7:34mm:25mm:5x5_100", "chessboard:8x5:24mm"],
  a3: ["charuco:7x10:36mm:27mm:5x5_100", "chessboard:9x6:30mm"], tabloid: ["charuco:7x10:36mm:27mm:5x5_100", "chessboard:9x6:30mm"],
  a2: ["charuco:10x14:38mm:28mm:5x5_250", "chessboard:13x9:36mm"] };
let socket = null, state = null, picture = null, clicks = null, drag = null, chosen = null;
// Which page sends an edit, and the revision that it had when the person began: see edit_log.hpp.
const page = Math.random().toString(36).slice(2, 12), began = new WeakMap();
let newest = null, in_frame = false, wanted_camera = null, masking = null;  // masking: the surface's name and the corners clicked so far

function send(verb, more) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return;
  socket.send(JSON.stringify(Object.assign({ do: verb, page, seen: state.revision }, more)));
}
// Of a field: since it has the focus, or since its last change.
function seenBy(input) {
  const seen = began.get(input) || state.revision;
  began.set(input, state.revision);
  return seen;
}
addEventListener("focusin", event => { if (state) began.set(event.target, state.revision); });
// Without a state there is nothing to decide about, and without a connection a click would be lost.
function usable(yes) { for (const part of document.querySelectorAll("nav, #panel")) part.inert = !yes; }
function connect() {
  socket = new WebSocket("ws://" + location.host + "/ws?token=" + encodeURIComponent(token));
  socket.binaryType = "blob";
  socket.onmessage = event => {
    if (typeof event.data === "string") { state = JSON.parse(event.data); usable(true); draw(); return; }
    const next = URL.createObjectURL(event.data);
    $("image").onload = () => { $("image").hidden = in_frame; $("blank").hidden = true; if (picture) URL.revokeObjectURL(picture); picture = next; socket.send("seen"); };
    $("image").src = next;
  };
  socket.onopen = () => { $("link").textContent = "connected"; $("link").className = ""; };
  socket.onclose = () => { usable(false); $("link").textContent = "not connected"; $("link").className = "lost"; setTimeout(connect, 1000); };
}
const number = (value, digits) => value === null || value === undefined ? "–" : value.toFixed(digits);
// What a person is typing stays as it is.
function put(id, value) { const input = $(id); if (document.activeElement !== input && input.value !== String(value)) input.value = value; }
function options(select, list, now) {
  const key = JSON.stringify([list, now]);
  if (select.dataset.shows === key) return;
  select.dataset.shows = key;
  const first = now ? [] : [new Option("choose ...", "", true, true)];
  const known = list.some(item => item.text === now) || !now ? [] : [new Option(now + " (not found)", now, false, true)];
  select.replaceChildren(...first, ...known, ...list.map(item => new Option(item.words, item.text, false, item.text === now)));
}
// What is drawn anew keeps the keyboard's focus.
function replace(parent, nodes) {
  const had = parent.contains(document.activeElement) ? document.activeElement.id : "";
  parent.replaceChildren(...nodes);
  if (had && $(had)) $(had).focus({ preventScroll: true });
}
function done(id) { return state.steps.some(step => step.id === id && step.done); }
function draw() {
  const s = state, busy = s.job !== "";
  $("project").textContent = (s.project.split("/").filter(Boolean).pop() || "") + (s.simulated ? " (simulated)" : "");
  $("project").title = s.project;
  $("rate").textContent = s.camera.open ? number(s.camera.images_per_s, 0) + " images/s" : "";
  drawSteps();
  for (const section of document.querySelectorAll("section")) section.hidden = section.dataset.step !== s.step;
  for (const b of document.querySelectorAll("[data-needs]")) b.disabled = busy || !done(b.dataset.needs);
  $("error").hidden = !s.error;
  if (s.error) { $("what").textContent = s.error.what; $("why").textContent = "Why: " + s.error.why; $("fix").textContent = "Next: " + s.error.next; }
  $("busy").hidden = !busy;
  $("doing").textContent = s.doing + (["show", "map"].includes(s.job) ? ": " + s.done : s.total > 0 ? ": " + s.done + " of " + s.total : "");
  if (s.total > 0 && !["show", "map"].includes(s.job)) { $("bar").max = s.total; $("bar").value = s.done; } else $("bar").removeAttribute("value");
  drawEdits();
  const said = s.messages.slice(-2), key = JSON.stringify(said);
  if ($("messages").dataset.shows !== key) {
    $("messages").dataset.shows = key;
    $("messages").replaceChildren(...said.map(text => { const line = document.createElement("div"); line.textContent = line.title = text; return line; }));
  }
  ({ display: drawDisplay, camera: drawCamera, board: drawBoard, capture: drawCapture, calibrate: drawRig,
    surfaces: drawSurfaces, content: drawContent, show: drawShow })[s.step]();
  marks();
}
// A page that is overtaken by another one decides; one whose view is changed by another one is informed.
function drawEdits() {
  const thing = state.held[page];
  $("held").hidden = !thing;
  if (thing) $("other").hidden = true;
  if (thing) $("held_words").textContent = "Another page has changed " + thing + " while you were editing it. Your change is not made yet.";
  if (newest !== null && state.edit.revision > newest && state.edit.page !== page && !thing) {
    $("other").textContent = (state.edit.page ? "Another page" : "A script") + " has changed " + state.edit.thing + ".";
    $("other").hidden = false;
    clearTimeout(drawEdits.timer); drawEdits.timer = setTimeout(() => { $("other").hidden = true; }, 8000);
  }
  newest = state.edit.revision;
}
function drawSteps() {
  const key = JSON.stringify([state.steps, state.step, state.job]);
  if ($("steps").dataset.shows === key) return;
  $("steps").dataset.shows = key;
  replace($("steps"), state.steps.map((step, i) => {
    const item = document.createElement("li"), button = document.createElement("button"), small = document.createElement("small");
    button.textContent = (i + 1) + " " + titles[step.id];
    small.textContent = step.done ? "done" : "open"; button.append(small);
    if (step.id === state.step) button.setAttribute("aria-current", "step");
    button.dataset.step = step.id; button.id = "step_" + step.id;
    button.disabled = state.job !== "" && step.id !== state.step;
    button.onclick = () => send("step", { text: step.id });
    item.append(button); return item;
  }));
}
function drawDisplay() {
  $("map").disabled = state.job !== "" || !state.display.open;
  $("mapping").hidden = state.job !== "map" || !state.show.url; if (state.show.url) $("map_control").href = state.show.url;
  options($("display"), state.display.list || [], state.display.chosen);
  drawFurther();
  $("identify").disabled = state.job !== "" || !(state.display.list || []).length;
  const shown = state.display.open ? [state.display.chosen, ...state.display.further].join("\n") + "\n" + (state.job === "identify") : "";
  if ($("cards").dataset.shows === shown) return;
  $("cards").dataset.shows = shown;
  const images = shown ? [state.display.chosen, ...state.display.further].map((text, i) => {
    const card = document.createElement("img"); card.alt = "the test card on projector " + (i + 1); card.src = frameOf(i, shown); return card; }) : [];
  $("cards").replaceChildren(...images);
}
// The frame of a projector, fetched again when `of` changes.
function frameOf(number, of) { return "/projector" + (number ? "_" + (number + 1) : "") + ".png?token=" + encodeURIComponent(token) + "&of=" + encodeURIComponent(of); }
function drawFurther() {
  const d = state.display, used = [d.chosen, ...d.further], free = (d.list || []).filter(item => !used.includes(item.text));
  $("further_of").hidden = !d.chosen || !free.length;
  $("further_display").disabled = state.job !== "";
  options($("further_display"), free, "");
  const key = JSON.stringify([d.further, d.list, state.job !== ""]);
  if ($("further").dataset.shows === key) return;
  $("further").dataset.shows = key;
  replace($("further"), d.further.map((text, i) => {
    const row = document.createElement("div"), words = document.createElement("span"), remove = document.createElement("button");
    row.className = "row"; words.className = "grow"; words.textContent = "Projector " + (i + 2) + ": " + ((d.list || []).find(item => item.text === text) || { words: text + " (not found)" }).words;
    remove.textContent = "Remove"; remove.id = "remove_display_" + (i + 2); remove.disabled = state.job !== "";
    remove.onclick = () => send("remove_display", { numbers: [i + 1] });
    row.append(words, remove); return row;
  }));
}
function drawCamera() {
  const c = state.camera;
  options($("camera"), c.list || [], c.chosen);
  $("modes").hidden = state.simulated;
  drawPreviews(c);
  put("camera_size", c.wanted_size); put("exposure", c.exposure);
  $("images").textContent = c.open ? c.size[0] + " x " + c.size[1] + ", " + number(c.images_per_s, 0) + " a second" : "no camera";
  $("clipped").textContent = number(c.saturated, 1) + " % of the pixels" + (c.saturated > 2 ? ": too bright, reduce the exposure" : ": fine");
  $("brightness").textContent = number(c.brightness, 0) + " of 255"; $("sharpness").textContent = number(c.sharpness, 1);
  $("check").disabled = state.job !== "" || !c.open || !state.display.open;
}
// A click on a camera's image chooses that camera.
function drawPreviews(c) {
  const looking = state.job === "look", list = looking ? (c.list || []).filter(item => item.preview) : [];
  $("look_around").disabled = state.job !== "";
  if (wanted_camera && state.job === "") { send("camera", { text: wanted_camera }); wanted_camera = null; }
  const key = JSON.stringify(list.map(item => [item.text, item.fault]));
  if ($("previews").dataset.shows !== key) {
    $("previews").dataset.shows = key;
    replace($("previews"), list.map(item => {
      const choose = document.createElement("button"), image = document.createElement("img"), words = document.createElement("div");
      choose.className = "preview"; choose.id = "preview_" + item.preview;
      image.alt = ""; words.textContent = item.words + (item.fault ? ": " + item.fault : "");
      choose.onclick = () => { wanted_camera = item.text; send("stop"); };
      choose.append(image, words); return choose; }));
  }
  for (const item of list) {
    const image = $("preview_" + item.preview).firstChild;
    // The next one when the last one has come.
    if (item.images && image.dataset.shows !== String(item.images) && image.complete) {
      image.dataset.shows = item.images;
      image.src = "/camera_" + item.preview + ".jpg?token=" + encodeURIComponent(token) + "&of=" + item.images;
    }
  }
}
function drawBoard() {
  put("paper", state.board.paper); put("measured", state.board.measured);
  const list = (boards[state.board.paper] || boards.a4).map(text => ({ text, words: text }));
  const now = list.some(item => item.text === $("board").value) ? $("board").value : list[0].text;
  options($("board"), list, now);
  $("pdf").href = "/board.pdf?token=" + encodeURIComponent(token); $("pdf").hidden = !state.board.text;
  $("board_now").textContent = state.board.text ? "In use: " + state.board.text : "No board yet.";
}
function drawCapture() {
  const c = state.capture;
  put("views", c.wanted);
  $("captured").textContent = c.views + " of " + c.wanted + " poses";
  $("corners").textContent = c.corners.length + (c.why_not ? " (" + c.why_not + ")" : "");
  $("still").textContent = number(c.still_s, 1) + " s";
  $("covered").textContent = "camera " + number(c.camera_coverage, 0) + " %, projector " + number(c.projector_coverage, 0) + " %";
  $("next_pose").hidden = !c.next && !c.thinking;
  if (c.thinking) $("next_pose").textContent = "Working out the best next pose ...";
  else if (c.next) $("next_pose").textContent = "Next pose: " + c.next.words + (c.next.in_frame.length ? ". The projector shows the outline of the board as well." : "");
  $("capture").disabled = state.job !== "" || !state.board.text; $("take").disabled = state.job !== "capture";
  $("capture").textContent = c.views > 0 && c.views < c.wanted ? "Continue capturing" : "Start capturing";
}
function drawRig() {
  const r = state.rig;
  put("accept", r.accept_mm);
  $("calibrate").disabled = state.job !== "" || !done("capture");
  $("report").href = "/report?token=" + encodeURIComponent(token); $("report").parentElement.hidden = !r.there;
  $("verdict").hidden = !r.there;
  if (!r.there) return;
  const key = JSON.stringify(r);
  if ($("verdict").dataset.shows === key) return;
  $("verdict").dataset.shows = key;
  const line = (text, kind) => { const d = document.createElement("div"); d.textContent = text; if (kind) d.className = kind; return d; };
  $("verdict").replaceChildren(
    line(r.passed ? "Passed: the rig may be used." : "Not accepted: see below and the report.", r.passed ? "good" : "warn"),
    line("Predicted error at 2 m: " + number(r.predicted_mm, 2) + " mm (limit " + number(r.accept_mm, 1) + " mm)"),
    ...(r.true_mm === null ? [] : [line("True error at 2 m (simulated): " + number(r.true_mm, 2) + " mm")]),
    ...r.lines.map(text => line(text, "soft")));
}
function surfaceCards(section, build) {
  const list = section.querySelector(".list");
  const key = JSON.stringify([state.surfaces.list.map(s => [s.name, s.content, s.width, s.height, s.true_mm, s.masks.length]), state.contents, state.job !== ""]);
  if (list.dataset.shows === key) return;
  list.dataset.shows = key;
  replace(list, state.surfaces.list.map(s => {
    const card = document.createElement("div"), title = document.createElement("b"), size = document.createElement("div");
    card.className = "card"; title.textContent = s.name;
    size.textContent = (s.width ? number(s.width, 3) + " m x " + number(s.height, 3) + " m" : "a shape of a file")
      + (s.true_mm === undefined ? "" : "; true error " + number(s.true_mm, 2) + " mm rms, " + number(s.true_worst_mm, 2) + " mm at most");
    size.className = "soft"; card.append(title, size); build(card, s); return card;
  }));
}
function drawSurfaces() {
  $("scan").disabled = state.job !== "" || !state.rig.there;
  $("scan").textContent = state.surfaces.scanned ? "Measure the wall again" : "Measure the wall";
  const by = state.surfaces.measure_by, by_size = by === "size", files = state.surfaces.files || [];
  if (document.activeElement !== $("measure_by")) $("measure_by").value = by;
  put("depth", state.surfaces.depth); put("marker", state.surfaces.marker);
  $("depth_of").hidden = by !== "depth" || state.simulated; $("marker_of").hidden = by !== "marker"; $("scan").hidden = by_size;
  for (const part of document.querySelectorAll(".size_of")) part.hidden = !by_size;
  $("click").disabled = state.job !== "" || !state.surfaces.scanned || !state.rig.there || (by_size && !(+$("width").value > 0 && +$("height").value > 0));
  $("from_file").hidden = !files.length; $("add_file").disabled = state.job !== "";
  options($("file"), files.map(text => ({ text, words: text })), files.includes($("file").value) ? $("file").value : files[0]);
  $("radius_of").hidden = $("shape").value !== "round";
  $("clicking").textContent = clicks ? "Click corner " + (clicks.length + 1) + " of 4: " + ["top left", "top right", "bottom right", "bottom left"][clicks.length] + ". Escape ends."
    : masking ? "Click around the part of '" + masking.name + "' that stays dark. " + (masking.points.length < 3 ? "" : "Click the first corner again to finish. ") + "Escape ends." : "";
  surfaceCards(document.querySelector("section[data-step=surfaces]"), (card, s) => {
    const remove = document.createElement("button"); remove.textContent = "Remove"; remove.id = "remove_" + s.name; remove.disabled = state.job !== "";
    remove.onclick = () => send("remove", { name: s.name });
    const mask = document.createElement("button"); mask.textContent = "Mask a part"; mask.id = "mask_" + s.name; mask.disabled = state.job !== "";
    mask.onclick = () => { masking = { name: s.name, points: [] }; clicks = null; in_frame = false; draw(); };
    const row = document.createElement("div"); row.className = "row"; row.append(remove, mask);
    if (s.masks.length) {
      const unmask = document.createElement("button"); unmask.textContent = "Remove masks"; unmask.id = "unmask_" + s.name; unmask.disabled = state.job !== "";
      unmask.onclick = () => send("unmask", { name: s.name }); row.append(unmask);
    }
    card.append(row);
  });
}
function drawContent() {
  surfaceCards(document.querySelector("section[data-step=content]"), (card, s) => {
    const select = document.createElement("select"), color = document.createElement("input"), live = document.createElement("input");
    const files = state.contents || [], is_color = s.content.startsWith("#"), is_live = /^(camera:|ros2:|shm:|rtsp:|https?:)/.test(s.content);
    select.id = "content_" + s.name; color.id = "color_" + s.name; live.id = "live_" + s.name;
    live.setAttribute("aria-label", "live source of " + s.name); live.placeholder = "or live: camera:1, ros2:/topic, shm:name";
    live.value = is_live ? s.content : "";
    live.onchange = () => { if (live.value.trim()) send("content", { name: s.name, text: live.value.trim(), seen: seenBy(live) }); };
    select.setAttribute("aria-label", "content of " + s.name); color.setAttribute("aria-label", "color of " + s.name);
    select.replaceChildren(new Option("a color", "", false, is_color), ...(is_live ? [new Option(s.content, s.content, false, true)] : []), ...files.map(f => new Option(f, f, false, f === s.content)));
    select.onchange = () => send("content", { name: s.name, text: select.value || color.value, seen: seenBy(select) });
    color.type = "color"; color.value = is_color ? s.content : "#ffffff";
    color.onchange = () => send("content", { name: s.name, text: color.value, seen: seenBy(color) });
    card.append(select, color, live);
  });
}
function drawShow() {
  const running = state.job === "show";
  $("start").textContent = running ? "Stop" : "Start"; $("start").disabled = state.job !== "" && !running;
  for (const b of [...document.querySelectorAll("[data-picture]"), $("freeze")]) b.disabled = !running;
  $("shown").textContent = running ? "Running: " + state.show.frames + " frames" : "Not running.";
  $("control").hidden = !state.show.url; if (state.show.url) $("control").href = state.show.url;
  for (const id of ["check_drift", "correct_rig", "bump", "autostart"]) $(id).disabled = state.job !== "";
  $("correct_rig").hidden = !state.drift.can_correct; $("bump").hidden = !state.simulated;
  $("drift").hidden = !state.drift.walls.length;
  $("drift").replaceChildren(...state.drift.walls.map(wall => {
    const line = document.createElement("div"); line.textContent = wall.words; line.className = !wall.checked ? "soft" : wall.moved ? "bad" : "good"; return line; }));
  $("service").hidden = !state.service;
  $("enable").textContent = "systemctl --user enable --now '" + state.service.replaceAll("'", "'\\''") + "'";
  surfaceCards(document.querySelector("section[data-step=show]"), () => {});
}
// The drawing in screen pixels, whatever the image's resolution.
const shown_size = () => in_frame ? state.frame : state.camera.size;
const corners_of = s => in_frame ? s.in_frame : s.corners;
function layout() {
  const [w, h] = shown_size();
  if (!w) return 0;
  const box = $("stage").getBoundingClientRect();
  const scale = Math.min((box.width - 32) / w, Math.max(box.height - 32, 160) / h);
  $("view").style.width = w * scale + "px"; $("view").style.height = h * scale + "px";
  $("marks").setAttribute("viewBox", `-0.5 -0.5 ${w} ${h}`);
  return scale;
}
function shape(kind, attributes, className) {
  const node = document.createElementNS(svgns, kind);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (className) node.setAttribute("class", className);
  return node;
}
function polygon(points, className) { return shape("polygon", { points: points.map(p => p.join(",")).join(" ") }, className); }
function marks() {
  if (state.step !== "surfaces") masking = null;
  in_frame = in_frame && state.step === "surfaces" && !!state.frame && state.job === "";
  drawFrame();
  const scale = layout();
  if (!scale) return;
  const parts = [], c = state.capture;
  if (["camera", "capture"].includes(state.step))
    for (const lit of state.lit) if (lit) parts.push(polygon([lit[0], [lit[1][0], lit[0][1]], lit[1], [lit[0][0], lit[1][1]]], "lit"));
  if (["board", "capture"].includes(state.step)) {
    for (const p of c.corners) parts.push(shape("circle", { cx: p[0], cy: p[1], r: 3 / scale }, "found"));
    if (c.next) parts.push(polygon(c.next.outline, "next"));
  }
  if (["surfaces", "content", "show"].includes(state.step)) for (const s of state.surfaces.list) {
    if (corners_of(s).length !== 4) {
      if (!in_frame && s.outline.length) parts.push(polygon(s.outline, "wall"));
      continue;
    }
    const corners = corners_of(s).map((p, i) => drag && drag.name === s.name && drag.index === i ? drag.at : p);
    // A curved outline is drawn where the server has it; while a corner is dragged, straight lines.
    const moving = drag && drag.name === s.name;
    parts.push(polygon(s.round && !moving && !in_frame ? s.outline : corners, "wall"));
    const label = shape("text", { x: corners[0][0], y: corners[0][1] - 8 / scale });
    label.style.fontSize = 13 / scale + "px"; label.textContent = s.name; parts.push(label);
    if (state.step === "surfaces") corners.forEach((p, i) => {
      const dot = shape("circle", { cx: p[0], cy: p[1], r: 9 / scale, tabindex: 0, "aria-label": s.name + ", corner " + (i + 1) }, "handle");
      dot.dataset.name = s.name; dot.dataset.index = i; parts.push(dot);
    });
  }
  if (["surfaces", "content", "show"].includes(state.step) && !in_frame)
    for (const s of state.surfaces.list) for (const mask of s.masks) parts.push(polygon(mask, "masked"));
  if (masking && masking.points.length > 1) parts.push(shape("polyline", { points: masking.points.map(p => p.join(",")).join(" ") }, "masked open"));
  if (masking) for (const p of masking.points) parts.push(shape("circle", { cx: p[0], cy: p[1], r: 6 / scale }, "handle"));
  if (clicks) for (const p of clicks) parts.push(shape("circle", { cx: p[0], cy: p[1], r: 6 / scale }, "handle"));
  $("marks").setAttribute("class", clicks || masking ? "clicking" : "");
  const focus = document.activeElement && document.activeElement.dataset ? document.activeElement.dataset : {};
  $("marks").replaceChildren(...parts);
  if (focus.name !== undefined && focus.index !== undefined) {
    const again = parts.find(part => part.dataset.name === focus.name && part.dataset.index === focus.index);
    if (again) again.focus({ preventScroll: true });
  }
}
// The projector's frame under its handles, fetched again after each edit.
function drawFrame() {
  $("in_camera").setAttribute("aria-pressed", !in_frame); $("in_frame").setAttribute("aria-pressed", in_frame);
  $("in_frame").disabled = $("in_camera").disabled = state.job !== "" || !state.rig.there;
  $("frame_help").hidden = !in_frame; $("frame").hidden = !in_frame;
  $("image").hidden = in_frame || !picture;
  const names = [state.display.chosen, ...state.display.further].map((text, i) => ({ words: "projector " + (i + 1), text: String(i) }));
  $("frame_of").hidden = !in_frame || names.length < 2;
  options($("frame_of"), names, String(state.framed));
  const shown = in_frame ? [state.revision, state.outlines, state.framed].join(" ") : "";
  if ($("frame").dataset.shows === shown) return;
  $("frame").dataset.shows = shown;
  if (shown) $("frame").src = frameOf(state.framed, shown);
}
function at(event) {
  const box = $("marks").getBoundingClientRect(), [w, h] = shown_size();
  return [(event.clientX - box.left) / box.width * w - 0.5, (event.clientY - box.top) / box.height * h - 0.5];
}
$("marks").addEventListener("pointerdown", event => {
  if (!state || state.step !== "surfaces") return;
  event.preventDefault();
  if (clicks) {
    clicks.push(at(event));
    if (clicks.length === 4) {
      const is_round = $("shape").value === "round", radius = is_round && +$("radius").value > 0 ? [+$("radius").value] : [];
      const size = state.surfaces.measure_by === "size" ? [+$("width").value, +$("height").value] : [];
      send("surface", { name: chosen, text: $("shape").value, numbers: [...clicks.flat(), ...(size.length ? size : radius)] });
      clicks = null; $("name").value = "";
    }
    draw(); return;
  }
  if (masking) {
    const p = at(event), first = masking.points[0], reach = 12 * shown_size()[0] / $("marks").getBoundingClientRect().width;
    if (masking.points.length >= 3 && Math.hypot(p[0] - first[0], p[1] - first[1]) < reach) {
      send("mask", { name: masking.name, numbers: masking.points.flat() });
      masking = null;
    } else if (masking.points.length < 32) masking.points.push(p);
    draw(); return;
  }
  const { name, index } = event.target.dataset;
  if (index === undefined || state.job !== "") return;
  const p = corners_of(state.surfaces.list.find(s => s.name === name))[+index], m = at(event);
  drag = { name, index: +index, seen: state.revision, at: p.slice(), off: [p[0] - m[0], p[1] - m[1]] };
  event.target.focus(); $("marks").setPointerCapture(event.pointerId);
});
$("marks").addEventListener("pointermove", event => {
  if (!drag || drag.dropped) return;
  const m = at(event); drag.at = [m[0] + drag.off[0], m[1] + drag.off[1]]; marks();
});
$("marks").addEventListener("pointerup", () => {
  if (!drag) return;
  send(in_frame ? "corner_in_frame" : "corner", { name: drag.name, numbers: [drag.index, ...drag.at], seen: drag.seen });
  const dropped = drag; dropped.dropped = true; setTimeout(() => { if (drag === dropped) { drag = null; marks(); } }, 300);
});
$("marks").addEventListener("keydown", event => {
  const way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const { name, index } = event.target.dataset;
  if (!way || index === undefined) return;
  event.preventDefault();
  const step = event.shiftKey ? 10 : event.ctrlKey ? 1 : 0.2, p = corners_of(state.surfaces.list.find(s => s.name === name))[+index];
  send(in_frame ? "corner_in_frame" : "corner", { name, numbers: [+index, p[0] + way[0] * step, p[1] + way[1] * step] });
});
addEventListener("keydown", event => { if (event.key === "Escape" && (clicks || masking)) { clicks = masking = null; draw(); } });
for (const id of ["display", "camera", "paper", "measure_by"]) $(id).onchange = () => { if ($(id).value) send(id, { text: $(id).value, seen: seenBy($(id)) }); };
for (const id of ["camera_size", "exposure", "depth", "marker"]) $(id).onchange = () => send(id, { text: $(id).value.trim(), seen: seenBy($(id)) });
for (const b of document.querySelectorAll("[data-go]")) b.onclick = () => send("step", { text: b.dataset.go });
for (const b of document.querySelectorAll("[data-light]")) b.onclick = () => send("light", { text: b.dataset.light });
for (const b of document.querySelectorAll("[data-picture]")) b.onclick = () =>
  send("show_command", { text: JSON.stringify({ do: "picture", text: b.dataset.picture }) });
for (const id of ["shape", "width", "height"]) $(id).oninput = () => draw();
$("add_file").onclick = () => send("add_file", { text: $("file").value });
$("in_frame").onclick = () => { in_frame = true; clicks = masking = null; send("light", { text: "outlines" }); draw(); };
$("camera_other").onchange = () => { if ($("camera_other").value.trim()) send("camera", { text: $("camera_other").value.trim(), seen: seenBy($("camera")) }); $("camera_other").value = ""; };
$("in_camera").onclick = () => { in_frame = false; send("light", { text: "white" }); draw(); };
$("further_display").onchange = () => { if ($("further_display").value) send("further_display", { text: $("further_display").value, seen: seenBy($("further_display")) }); };
$("frame_of").onchange = () => send("frame_of", { numbers: [+$("frame_of").value] });
$("map").onclick = () => send("map");
$("identify").onclick = () => send("identify");
$("test_card").onclick = () => send("test_card");
$("look_around").onclick = () => send("look_around");
$("check").onclick = () => send("check_camera");
$("make_board").onclick = () => send("board", { text: $("board").value });
$("set_measured").onclick = () => send("measured", { text: $("measured").value.trim(), seen: seenBy($("measured")) });
$("views").onchange = () => send("views", { numbers: [+$("views").value], seen: seenBy($("views")) });
$("accept").onchange = () => send("accept", { numbers: [+$("accept").value], seen: seenBy($("accept")) });
for (const id of ["use_mine", "keep_theirs"]) $(id).onclick = () => send(id);
$("capture").onclick = () => send("capture");
$("take").onclick = () => send("take");
$("calibrate").onclick = () => send("calibrate");
$("scan").onclick = () => send("scan");
$("stop").onclick = () => send("stop");
for (const id of ["check_drift", "correct_rig", "bump", "autostart"]) $(id).onclick = () => send(id);
$("start").onclick = () => send(state.job === "show" ? "stop" : "show");
$("freeze").onclick = () => send("show_command", { text: JSON.stringify({ do: "freeze" }) });
$("click").onclick = () => {
  const taken = new Set(state.surfaces.list.map(s => s.name));
  let name = $("name").value.trim();
  for (let i = 1; !name || taken.has(name); ++i) name = "wall " + i;
  chosen = name; clicks = []; masking = null; in_frame = false; draw();
};
addEventListener("resize", () => { if (state) marks(); });
connect();
