"""python -m pyvotess: prints where the parts of an installed package are, for builds of other programs; or a report."""

import argparse
import platform
import sys
from importlib import metadata
from pathlib import Path
from typing import Iterator, Tuple

from . import _library
from .frames import _program
from .tessellator import devices

_PACKAGES = ("numpy", "scipy", "h5py", "matplotlib", "pandas", "pyvista", "ase", "jax", "torch", "mpi4py")


def _report() -> Iterator[Tuple[str, str]]:
    """Yields what a report of a fault needs: versions, places, devices."""
    yield "pyvotess", _library.VERSION
    yield "library", str(Path(_library.path).resolve() if Path(_library.path).exists() else _library.path)
    try:
        yield "clvotess", _program()
    except ImportError:
        yield "clvotess", "none: read_frames() needs it"
    yield "python", f"{platform.python_version()} ({platform.python_implementation()}), {sys.executable}"
    yield "system", f"{platform.system()} {platform.release()}, {platform.machine()}"
    for device in devices():
        yield f"device {device.id}", f"{device.name}: {device.description}"
    for package in _PACKAGES:
        try:
            yield package, metadata.version(package)
        except metadata.PackageNotFoundError:
            yield package, "none"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m pyvotess", description=__doc__)
    group = parser.add_mutually_exclusive_group(required=True)
    for part, text in (
        ("cmake-dir", "value of -Dvotess_DIR= for find_package(votess)"),
        ("include-dir", "folder of the C and C++ headers"),
        ("library", "file of the loaded libvotess"),
        ("version", "the version"),
        ("info", "versions, places and devices, for a report of a fault"),
    ):
        group.add_argument(f"--{part}", action="store_const", const=part, dest="part", help=text)
    part = parser.parse_args().part
    if part == "version":
        print(_library.VERSION)
    elif part == "info":
        for name, value in _report():
            print(f"{name:<12}{value}")
    elif part == "library":
        print(_library.path)
    else:
        folder = Path(__file__).resolve().parent / ("lib/cmake/votess" if part == "cmake-dir" else "include")
        if not folder.is_dir():
            parser.error(f"there is no {folder}: run `pip install`; a source tree lacks it")
        print(folder)


main()
