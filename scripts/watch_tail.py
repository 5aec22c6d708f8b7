#!/usr/bin/env python3
"""The tail of the watch's test from simulated windows without a movement:

    test_watch --gtest_filter=WatchFigures.Windows | scripts/watch_tail.py

The windows of one installation and content have most of their errors in common. So each installation counts once for a
content, with its largest statistic x = -ln(probability). Without errors of the model x of one window is exponential with
mean 1. Windows whose light may be on something before the wall have their own alarm, and one beyond the limit in which few
cells moved has none: both are counted and not fitted. The values above their median are fitted by u + exponential(b). The
probability of x > -ln(limit) is then

    0.5 exp(-(-ln(limit) - u) / b)

Its 90 % interval is that of 2000 samples drawn with replacement.
"""
import math
import random
import sys

WEEK_S, WINDOW_S = 604800, 2.0
LIMIT = WINDOW_S / WEEK_S
MAX_OF_OTHERS = 1e-3  # as in src/watch/watch.cpp


def largest_by_content(lines):
    values = {}
    counts = {}
    not_fitted = {}
    for line in lines:
        fields = line.strip().split(",")
        if len(fields) != 11 or fields[0] == "content":
            continue
        content, installation, probability = fields[0], int(fields[1]), float(fields[5])
        if fields[9] == "1" or (probability < LIMIT and float(fields[10]) >= MAX_OF_OTHERS):
            not_fitted[content] = not_fitted.get(content, 0) + 1
            continue
        x = -math.log(max(probability, 1e-300))
        one = values.setdefault(content, {})
        one[installation] = max(one.get(installation, 0.0), x)
        counts.setdefault(content, []).append((installation, int(fields[2]), x, int(fields[7])))
    return values, counts, not_fitted


def tail(sample):
    """Median u and mean excess b above it."""
    ordered = sorted(sample)
    u = ordered[len(ordered) // 2]
    above = [x - u for x in ordered if x > u]
    return u, sum(above) / len(above) if above else 1e-9


def log10_beyond(sample):
    u, b = tail(sample)
    way = -math.log(LIMIT) - u
    return (math.log(0.5) - max(0.0, way) / b) / math.log(10)


def following(windows, level):
    """Share of windows beyond a level whose next one is beyond it as well; their number."""
    known = {(i, w): x for i, w, x, _ in windows}
    beyond = [(i, w) for (i, w), x in known.items() if x > level and (i, w + 1) in known]
    return sum(known[(i, w + 1)] > level for i, w in beyond), len(beyond)


def main():
    values, windows, not_fitted = largest_by_content(sys.stdin)
    if not values:
        sys.exit("watch_tail: no lines of WatchFigures.Windows on the standard input")
    chance = random.Random(1)
    for content, one in values.items():
        sample = list(one.values())
        u, b = tail(sample)
        drawn = sorted(log10_beyond([chance.choice(sample) for _ in sample]) for _ in range(2000))
        all_x = [x for _, _, x, _ in windows[content]]
        both, beyond = following(windows[content], math.log(10))
        print(f"{content}: {len(sample)} installations, {len(all_x)} windows, "
              f"p < 0.1 in {sum(x > math.log(10) for x in all_x)}, < 0.01 in {sum(x > math.log(100) for x in all_x)}, "
              f"smallest p {math.exp(-max(all_x)):.2g}; of {beyond} below 0.1 the next was too in {both}; "
              f"alarms {sum(a for _, _, _, a in windows[content])}; {not_fitted.get(content, 0)} other windows")
        print(f"  largest of an installation: u {u:.2f}, b {b:.2f}; log10 of the probability beyond {LIMIT:.2g}: "
              f"{log10_beyond(sample):.1f} (90 %: {drawn[100]:.1f} to {drawn[1899]:.1f})")


main()
