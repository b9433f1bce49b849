"""python -m pyvotess: prints where the parts of an installed package are, for builds of other programs."""

import argparse
from pathlib import Path

from . import _library


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m pyvotess", description=__doc__)
    group = parser.add_mutually_exclusive_group(required=True)
    for part, text in (
        ("cmake-dir", "value of -Dvotess_DIR= for find_package(votess)"),
        ("include-dir", "folder of the C and C++ headers"),
        ("library", "file of the loaded libvotess"),
        ("version", "the version"),
    ):
        group.add_argument(f"--{part}", action="store_const", const=part, dest="part", help=text)
    part = parser.parse_args().part
    if part == "version":
        print(_library.VERSION)
    elif part == "library":
        print(_library.path)
    else:
        folder = Path(__file__).resolve().parent / ("lib/cmake/votess" if part == "cmake-dir" else "include")
        if not folder.is_dir():
            parser.error(f"there is no {folder}: run `pip install`; a source tree lacks it")
        print(folder)


main()
