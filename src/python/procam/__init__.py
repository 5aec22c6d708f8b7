"""Projector-camera calibration, surfaces and undistorted projection, with the error in millimetres.

Names, units and conventions are those of the C++ library: metres, radians, seconds, pixels; a pose is named
target_from_source; pixel (0, 0) is the centre of the top left pixel. Images are numpy arrays of shape (h, w) or
(h, w, c); points float64 arrays of shape (n, 2) or (n, 3).
"""

from . import _procam  # fills this package and its submodules
from ._version import __version__
