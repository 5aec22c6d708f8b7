#!/usr/bin/env python3
"""What Python adds to the time of the C++ library:   python_overhead.py PYTHON_PAIRS CAPTURES

Each work runs in turns, by the program python_pairs and here, on the same data with the same options; the ratio is that of
the fastest rounds (what else runs on the machine only adds time) and, beside it, of the medians.
"""

import argparse
import statistics
import subprocess
import time

import numpy

import procam


def picture():
    y, x, c = numpy.mgrid[0:720, 0:1280, 0:3]
    return (x * 7 + y * 13 + c * 50).astype(numpy.uint8)


def render(frame_after_frame):
    projector = procam.Projector(procam.Camera(procam.ImageSize(1920, 1080), procam.Intrinsics(2000, 2010, 950, 1000, 0)))
    plane = procam.PlacedPlane([[1.6, 0, -0.8], [0, 0.9, -0.9], [0, 0, 1]], procam.se3_exp([0.1, 0.2, 0, 0, 0, 2]))
    scene = procam.Scene([procam.SceneItem(plane, picture())])
    frame = numpy.zeros((1080, 1920, 3), numpy.uint8)
    options = procam.render.RenderOptions(threads=1)
    renderer = procam.render.CpuRenderer(options)
    if frame_after_frame:
        return lambda: renderer.render(scene, projector, frame)
    return lambda: procam.render.render(scene, projector, frame, options)


def decode():
    code = procam.pattern.GrayCode(procam.ImageSize(1024, 768), 1)
    captures = procam.pattern.frames(code)
    return lambda: procam.pattern.decode(captures, code)


def calibrate(captures):
    contents = procam.session.read(procam.session.open(captures))
    return lambda: procam.calibrate.calibrate_rig(contents.correspondences)


def rounds_here(work, rounds):
    work()
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("captures")
    parser.add_argument("--turns", type=int, default=6)
    arguments = parser.parse_args()
    works = (("render", 10, render(False)), ("renderer", 30, render(True)), ("decode", 10, decode()),
             ("calibrate", 3, calibrate(arguments.captures)))
    print("work         C++ ms   Python ms   ratio of the fastest   ratio of the medians")
    for name, rounds, work in works:
        cpp, python = [], []
        for _ in range(arguments.turns):
            out = subprocess.run([arguments.program, name, str(rounds), arguments.captures], check=True, capture_output=True,
                                 text=True)
            cpp += [float(line) for line in out.stdout.split()]
            python += rounds_here(work, rounds)
        print(f"{name:10} {1000 * min(cpp):9.3f} {1000 * min(python):11.3f} {min(python) / min(cpp):22.4f} "
              f"{statistics.median(python) / statistics.median(cpp):22.4f}")


if __name__ == "__main__":
    main()
