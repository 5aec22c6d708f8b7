#!/usr/bin/env python3
"""The picture of docs/watch.md from the lines of a simulated show:

    test_watch --gtest_filter=WatchFigures.Timeline | scripts/watch_plot.py > docs/images/watch.svg
"""
import sys

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 860, 330, 60, 42, 20, 48
COLOURS = {"ok": "#cfe8cf", "starting": "#eeeeee", "suspected": "#fbe6b8", "moved": "#f4b9b0", "inseparable": "#e3c3ee"}


def rows(lines):
    header = None
    for line in lines:
        fields = line.strip().split(",")
        if fields[0] == "time":
            header = fields
        elif header and len(fields) == len(header):
            yield dict(zip(header, fields))


def main():
    data = list(rows(sys.stdin))
    if not data:
        sys.exit("watch_plot: no lines of WatchFigures.Timeline on the standard input")
    end = float(data[-1]["time"])
    top = max(float(row["true_mm"]) for row in data) * 1.15
    x = lambda t: LEFT + (WIDTH - LEFT - RIGHT) * t / end
    y = lambda mm: HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * min(mm, top) / top
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>']
    for before, row in zip([None, *data], data):
        t0 = float(before["time"]) if before else 0.0
        out.append(f'<rect x="{x(t0):.1f}" y="{TOP}" width="{x(float(row["time"])) - x(t0) + 0.3:.1f}" '
                   f'height="{HEIGHT - TOP - BOTTOM}" fill="{COLOURS.get(row["state"], "#d8d8d8")}"/>')
    for mm in range(0, int(top) + 1, 2):
        out.append(f'<path d="M{LEFT} {y(mm):.1f}H{WIDTH - RIGHT}" stroke="#00000022"/>'
                   f'<text x="{LEFT - 8}" y="{y(mm) + 4:.1f}" text-anchor="end">{mm}</text>')
    for t in range(0, int(end) + 1, 5):
        out.append(f'<text x="{x(t):.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{t}</text>')
    band = [(x(float(r["time"])), float(r["error_mm"]), float(r["sigma_mm"])) for r in data]
    upper = " ".join(f"{px:.1f},{y(error + 2 * sigma):.1f}" for px, error, sigma in band)
    lower = " ".join(f"{px:.1f},{y(max(0, error - 2 * sigma)):.1f}" for px, error, sigma in reversed(band))
    out.append(f'<polygon points="{upper} {lower}" fill="#1f5fa8" opacity="0.25"/>')
    for name, colour, dash in (("true_mm", "#222222", "5 4"), ("error_mm", "#1f5fa8", "")):
        points = " ".join(f'{x(float(r["time"])):.1f},{y(float(r[name])):.1f}' for r in data)
        out.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2" stroke-dasharray="{dash}"/>')
    out.append(f'<text x="{LEFT}" y="{HEIGHT - 8}">time, s</text>'
               f'<text x="{LEFT - 46}" y="16">error of the light on the wall, mm RMS</text>')
    legend = [("true", "#222222"), ("estimated, with two sigmas", "#1f5fa8")]
    place = 330
    for text, colour in legend:
        out.append(f'<path d="M{place} 12h22" stroke="{colour}" stroke-width="2"/><text x="{place + 28}" y="16">{text}</text>')
        place += 50 + 7 * len(text)
    place = 330
    for state in ("ok", "suspected", "moved", "inseparable"):
        out.append(f'<rect x="{place}" y="23" width="14" height="12" fill="{COLOURS[state]}"/>'
                   f'<text x="{place + 19}" y="34">{state}</text>')
        place += 40 + 8 * len(state)
    print("\n".join(out + ["</svg>"]))


main()
