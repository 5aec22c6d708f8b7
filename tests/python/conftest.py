"""What the tests share: the package of the build, a small simulated session, a scene."""

import os
import pathlib

import numpy
import pytest

import procam


@pytest.fixture(scope="session")
def captures() -> pathlib.Path:
    """A simulated session of four views, made with the tests of the tools."""
    folder = pathlib.Path(os.environ["PROCAM_E2E_SESSION"])
    assert (folder / "session.json").exists()
    return folder


@pytest.fixture(scope="session")
def tools() -> pathlib.Path:
    return pathlib.Path(os.environ["PROCAM_TOOLS"])


@pytest.fixture(scope="session")
def contents(captures: pathlib.Path) -> "procam.session.SessionContents":
    return procam.session.read(procam.session.open(captures))


@pytest.fixture(scope="session")
def calibrated(contents: "procam.session.SessionContents") -> "procam.calibrate.CalibrationResult":
    return procam.calibrate.calibrate_rig(contents.correspondences)


@pytest.fixture
def projector() -> procam.Projector:
    """Nothing of it is symmetric."""
    lens = procam.Intrinsics(fx=700.0, fy=712.0, cx=305.0, cy=460.0, skew=1.5)
    distortion = procam.BrownConrady(coefficients=[-0.06, 0.02, 0.001, -0.0005, 0.0])
    return procam.Projector(procam.Camera(procam.ImageSize(640, 400), lens, distortion))


@pytest.fixture
def scene() -> procam.Scene:
    """A picture on a plane 2 m away, askew."""
    rng = numpy.random.default_rng(3)
    picture = rng.integers(0, 256, (90, 160, 3), dtype=numpy.uint8)
    plane_from_content = numpy.array([[1.6, 0.1, -0.9], [0.0, 0.9, -1.0], [0.0, 0.05, 1.0]])
    pose = procam.se3_exp([0.1, -0.3, 0.05, 0.1, -0.2, 2.0])
    return procam.Scene([procam.SceneItem(procam.PlacedPlane(plane_from_content, pose), picture)], (10, 20, 30))
