"""python -m pyvotess: where the parts of an installed package lie, for builds of other programs."""

import argparse
from pathlib import Path

from . import _library


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m pyvotess", description=__doc__)
    group = parser.add_mutually_exclusive_group(required=True)
    group.add_argument("--cmake-dir", action="store_true", help="what -Dvotess_DIR= takes, for find_package(votess)")
    group.add_argument("--include-dir", action="store_true", help="folder of the C and C++ headers")
    group.add_argument("--library", action="store_true", help="the file of libvotess that is used")
    group.add_argument("--version", action="store_true", help="the version")
    wish = parser.parse_args()
    package = Path(__file__).resolve().parent
    if wish.version:
        print(_library.VERSION)
    elif wish.library:
        print(_library.path)
    else:
        folder = package / ("lib/cmake/votess" if wish.cmake_dir else "include")
        if not folder.is_dir():
            parser.error(f"there is no {folder}: it comes with `pip install`, not with a source tree")
        print(folder)


main()
