"""Mistakes that a checker of types must find: one in each line that ends in "# error"."""

import numpy
import numpy.typing

import procam

count: int = procam.ImageSize(3, 4).size  # error
text: str = procam.Intrinsics().fx  # error
procam.io.save_rig("rig.json", 5)  # error
procam.session.opne("folder")  # error
procam.ErrorKind.kNone  # error
pixels: numpy.typing.NDArray[numpy.uint8] = procam.Pose().translation  # error
