#!/usr/bin/env python3
"""Calibrates a folder of captures and inspects the result:   calibrate_folder.py captures

Prints each device's parameters with one standard deviation, the residuals of each view, the predicted error on a wall
at 2 m, and writes rig.json and a picture of all residuals.
"""

import argparse
import sys

import numpy

import procam


def print_parameters(rig):
    """The covariance has a row for each parameter that was estimated, by its name."""
    for device, lens in [*((one.name, one.camera) for one in rig.cameras),
                         *((one.name, one.projector.inverse_camera) for one in rig.projectors)]:
        print(f"\n{device}: {lens.size.width} x {lens.size.height}, lens {procam.name_of(lens.distortion)}")
        for name, value in zip(procam.parameter_names(lens), procam.parameters_of(lens)):
            full = f"{device}.{name}"
            sigma = rig.covariance.sigma(full)
            print(f"  {full:16} {value:12.5f}" + (f" +- {sigma:.5f}" if sigma > 0 else "  fixed"))


def print_views(result):
    print("\nview          " + "".join(f"{device.name:>14}" for device in result.devices) + "   RMS, px")
    for view in result.views:
        print(f"{view.name:14}" + "".join(f"{rms:14.3f}" for rms in view.rms_px) + ("" if view.used else "   rejected: " + view.note))
    print(f"{'all':14}" + "".join(f"{rms:14.3f}" for rms in result.rms_px))


def residual_picture(result, longest=640, line=30):
    """One panel a device: each residual as a line from its pixel, most of them `line` pixels long or shorter; green used,
    red rejected. Returns the picture and how many times longer a line is than its residual."""
    lengths = [numpy.linalg.norm(one.residual) for one in result.residuals if one.used]
    scale = line / max(numpy.percentile(lengths, 95), 1e-9)
    panels = []
    for index, device in enumerate(result.devices):
        shrink = longest / max(device.size.width, device.size.height)
        panel = numpy.full((int(device.size.height * shrink), int(device.size.width * shrink), 3), 24, numpy.uint8)
        for residual in result.residuals:
            if residual.device != index:
                continue
            steps = numpy.linspace(0, 1, 40)[:, None]
            x, y = numpy.rint(residual.pixel * shrink + steps * scale * residual.residual).astype(int).T
            inside = (x >= 0) & (y >= 0) & (x < panel.shape[1]) & (y < panel.shape[0])
            panel[y[inside], x[inside]] = (60, 220, 90) if residual.used else (240, 70, 60)
        panels.append(panel)
    height = max(panel.shape[0] for panel in panels)
    return numpy.hstack([numpy.pad(panel, ((0, height - panel.shape[0]), (0, 8), (0, 0))) for panel in panels]), scale


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("captures", help="a session: session.json and a folder of images for each view")
    parser.add_argument("--rig", default="rig.json")
    parser.add_argument("--picture", default="residuals.png")
    arguments = parser.parse_args()

    contents = procam.session.read(procam.session.open(arguments.captures),
                                   lambda view, done, total: print(f"reading {view} ({done + 1} of {total})", file=sys.stderr))
    options = procam.calibrate.Options()
    # The lens models that predict held-out views best.
    options.camera.choose = options.projector.choose = True
    result = procam.calibrate.calibrate_rig(contents.correspondences, options)
    predicted = procam.analyze.check_predicted_errors(result)

    print_parameters(result.rig)
    print_views(result)
    for errors in predicted:
        print("\npredicted error " + procam.analyze.in_words(errors.externally))
    for remark in result.diagnostics.items:
        print(f"{remark.severity.name[1:].lower()}: {remark.message}")

    result.rig.provenance = procam.session.provenance(contents, "calibrate_folder.py")
    procam.io.save_rig(arguments.rig, result.rig)
    picture, scale = residual_picture(result)
    procam.io.save_image(arguments.picture, picture)
    print(f"\n{arguments.rig}; {arguments.picture}: residuals {scale:.0f} times as long as they are")
    return 0 if result.rig.quality.passed() else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except procam.Error as error:
        sys.exit(f"{error.subject}: {error.why}\n{error.next}")
