"""Finds, loads and checks libvotess."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys
from pathlib import Path
from typing import List, Tuple

from . import _c_api

#: Version of this package. It needs the library of the same version, see :func:`check`.
VERSION = "0.1.0"

_FOLDER = "lib"
if sys.platform == "win32":
    _FOLDER = "bin"  # beside the program
    _FILE_NAMES: Tuple[str, ...] = ("votess.dll", "libvotess.dll")
elif sys.platform == "darwin":
    _FILE_NAMES = ("libvotess.dylib",)
else:
    # Until 1.0 the name has the minor version, which may change the interface.
    _NUMBER = VERSION.rsplit(".", 1)[0] if VERSION.startswith("0.") else VERSION.split(".")[0]
    _FILE_NAMES = ("libvotess.so", "libvotess.so." + _NUMBER)

# Sanitizer builds need their run-time library loaded first. VOTESS_LIBRARY can name them.
_SKIPPED_BUILDS = ("asan", "tsan")


def _folders() -> List[Path]:
    """Returns the folders to search: this package, then the builds of a source tree, release first."""
    package = Path(__file__).resolve().parent
    folders = [package / _FOLDER]
    source = package.parents[2] if len(package.parents) > 2 else package
    if (source / "include" / "votess" / "votess.h").is_file():
        builds = [source / "build" / "release"]
        builds += sorted(p for p in (source / "build").glob("*") if p.name not in ("release", *_SKIPPED_BUILDS))
        folders += [build / _FOLDER for build in builds]
    return folders


def find() -> str:
    """Returns the path or name of the library. Raises ImportError, which lists the searched places."""
    named = os.environ.get("VOTESS_LIBRARY")
    if named:
        return named
    folders = _folders()
    for folder in folders:
        for name in _FILE_NAMES:
            if (folder / name).is_file():
                return str(folder / name)
    in_system = ctypes.util.find_library("votess")
    if in_system:
        return in_system
    places = "".join(f"\n  {folder}" for folder in folders)
    raise ImportError(
        f"{_FILE_NAMES[0]} was not found. Looked in{places}\n  the system's library path\n"
        "Build votess, or set VOTESS_LIBRARY to the file."
    )


def _numbers(version: str) -> Tuple[int, ...]:
    return tuple(int(part) for part in version.split("."))


def check(library: ctypes.CDLL, name: str) -> None:
    """Raises ImportError unless version and struct sizes of the library fit this package.

    The major version must be equal, and the minor version not older; before 1.0 it must be equal too.
    """
    names = ("votess_version_string", "votess_sizeof_options", "votess_sizeof_stats")
    _c_api.declare(library, {name: _c_api.SIGNATURES[name] for name in names})
    found = library.votess_version_string().decode()
    ours, theirs = _numbers(VERSION), _numbers(found)
    suits = ours[0] == theirs[0] and (ours[1] == theirs[1] if ours[0] == 0 else ours[1] <= theirs[1])
    if not suits:
        raise ImportError(
            f"{name} is votess {found}, but this pyvotess is {VERSION}: install the same version of both, "
            "or set VOTESS_LIBRARY to the file of the right one."
        )
    for struct, size in (
        (_c_api.Options, library.votess_sizeof_options()),
        (_c_api.Stats, library.votess_sizeof_stats()),
    ):
        # A newer library may have more fields at the end of a struct, never fewer.
        if size < ctypes.sizeof(struct):
            raise ImportError(
                f"{name} has {size} bytes for {struct.__doc__} where pyvotess {VERSION} has {ctypes.sizeof(struct)}: "
                "install the same version of both."
            )


def load() -> Tuple[ctypes.CDLL, str]:
    """Returns the checked library with its signatures, and its path or name."""
    name = find()
    try:
        library = ctypes.CDLL(name)
    except OSError as error:
        named = " (named by VOTESS_LIBRARY)" if os.environ.get("VOTESS_LIBRARY") else ""
        raise ImportError(f"the votess library {name}{named} cannot be loaded: {error}") from error
    try:
        check(library, name)
        _c_api.declare(library)
    except AttributeError as error:
        raise ImportError(
            f"{name} is not the library of votess {VERSION}: {error}. Install the same version of both, "
            "or set VOTESS_LIBRARY to the file of the right one."
        ) from error
    return library, name


lib, path = load()
