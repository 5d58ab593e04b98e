"""Corrects the CMake files that the ROS wheels install, so that interface packages can be built against them.

The wheels' exported targets name the Python and NumPy include folders of the machine that built them; they are
replaced by those of the interpreter that runs this script (the environment's own).
"""

import re
import sys
import sysconfig
from pathlib import Path

import numpy

FOREIGN = re.compile(r'[^;"]*/include/python3[.\d]*(?=[;"])|[^;"]*/site-packages/numpy/(?:_core|core)/include(?=[;"])')


def corrected(text: str) -> str:
    """The CMake text with every Python and NumPy include folder replaced by this environment's."""
    own = {"python": sysconfig.get_path("platinclude"), "numpy": numpy.get_include()}
    return FOREIGN.sub(lambda found: own["numpy" if "/numpy/" in found.group() else "python"], text)


def main() -> None:
    for path in Path(sys.prefix).glob("share/*/cmake/*.cmake"):
        text = path.read_text(encoding="utf-8")
        if (new := corrected(text)) != text:
            path.write_text(new, encoding="utf-8")


if __name__ == "__main__":
    main()
