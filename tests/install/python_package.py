"""The Python package of a prefix is whole and finds its libraries:   python_package.py PREFIX/lib/python3/dist-packages"""

import pathlib
import sys

import procam

package = pathlib.Path(procam.__file__).parent
assert package == pathlib.Path(sys.argv[1]) / "procam", package
for file in ("py.typed", "__init__.pyi", "session.pyi", "_version.py"):
    assert (package / file).exists(), file
assert "gray" in procam.session.pattern_help()
assert abs(procam.se3_log(procam.se3_exp([0, 0, 0.1, 1, 2, 3]))[2] - 0.1) < 1e-12
print(package, procam.__version__)
