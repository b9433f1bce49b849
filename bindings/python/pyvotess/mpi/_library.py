"""Finds and loads libvotess_mpi, and declares its functions (votess/mpi.h)."""

from __future__ import annotations

import ctypes
import ctypes.util
import os
import sys
from ctypes import c_int, c_size_t, c_void_p
from pathlib import Path
from typing import Any, Tuple

from .. import _library
from .._c_api import declare, read_headers, read_types, signatures

if sys.platform == "darwin":
    _FILE_NAMES: Tuple[str, ...] = ("libvotess_mpi.dylib",)
else:
    _FILE_NAMES = ("libvotess_mpi.so", "libvotess_mpi.so." + _library.VERSION.split(".")[0])


_TEXT = read_headers("mpi.h")


MpiCounts = read_types(_TEXT)["MpiCounts"]


def _find() -> str:
    """Returns the path of the library: in the folder of libvotess, or where the system finds it."""
    folder = Path(_library.path).parent
    for name in _FILE_NAMES:
        if os.path.dirname(_library.path) and (folder / name).is_file():
            return str(folder / name)
    in_system = ctypes.util.find_library("votess_mpi")
    if in_system:
        return in_system
    raise ImportError(
        f"{_FILE_NAMES[0]} was not found in the folder of {_library.path} nor in the system's library path. Wheels lack "
        "it: build votess where MPI is installed, and set VOTESS_LIBRARY to its libvotess."
    )


def _load(size_of_comm: int) -> ctypes.CDLL:
    name = _find()
    try:
        library = ctypes.CDLL(name)
    except OSError as error:
        raise ImportError(f"{name} cannot be loaded: {error}") from error
    declare(library, {"votess_mpi_sizeof_comm": (c_size_t, ())})
    if library.votess_mpi_sizeof_comm() != size_of_comm:
        raise ImportError(f"{name} was built with another MPI than mpi4py: build both with the same MPI")
    communicator = c_int if size_of_comm == ctypes.sizeof(c_int) else c_void_p
    declare(library, signatures(_TEXT, MPI_Comm=communicator))
    return library


def load() -> Tuple[ctypes.CDLL, Any]:
    """Returns the library, and a function that converts a communicator of mpi4py to its argument.

    Raises ImportError without the library or mpi4py.
    """
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise ImportError("pyvotess.mpi needs mpi4py") from error
    size = MPI._sizeof(MPI.Comm)
    read = c_int if size == ctypes.sizeof(c_int) else c_void_p

    def handle(comm: Any) -> Any:
        if not isinstance(comm, MPI.Comm) or comm == MPI.COMM_NULL:
            raise TypeError(f"comm must be a communicator of mpi4py, not {comm!r}")
        return read.from_address(MPI._addressof(comm))

    return _load(size), handle
