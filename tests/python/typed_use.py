"""Uses of the package as a checker of types must see them: mypy --strict accepts this file."""

import pathlib
from typing import Optional

import numpy
import numpy.typing

import procam


def calibrate(folder: pathlib.Path) -> procam.Rig:
    contents = procam.session.read(procam.session.open(folder))
    result = procam.calibrate.calibrate_rig(contents.correspondences, procam.calibrate.Options(max_iterations=50))
    return result.rig


def focal_length(rig: procam.Rig) -> float:
    return rig.projector().projector.inverse_camera.intrinsics.fx


def pixel(projector: procam.Projector, point: numpy.typing.NDArray[numpy.float64]) -> Optional[numpy.ndarray]:  # type: ignore[type-arg]
    return projector.project(point)


def frame(placement: procam.PlacedPlane, projector: procam.Projector) -> numpy.ndarray:  # type: ignore[type-arg]
    scene = procam.Scene([procam.SceneItem(placement, numpy.zeros((4, 4, 3), numpy.uint8))])
    return procam.render.render(scene, projector)


def kind(error: procam.Error) -> str:
    return f"{error.kind.name}: {error.next_step}"


def names(surfaces: procam.SurfaceSet) -> list[str]:
    return [one.name for one in surfaces.surfaces]


class Pattern(procam.session.SessionPattern):
    def frame_count(self) -> int:
        return 3
