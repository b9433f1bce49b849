"""Declarations of votess/stream.h for ctypes."""

from __future__ import annotations

import ctypes
from ctypes import CFUNCTYPE, POINTER, c_char, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from typing import Any, Dict, Tuple

import numpy as np

from .._c_api import Options, Stats
from .._library import lib

STOP, END, GO_ON = -1, 0, 1


class Seeds(ctypes.Structure):
    """``votess_stream_seeds``."""

    _fields_ = [("count", c_size_t), ("points", c_void_p), ("weights", c_void_p), ("radii", c_void_p)]


class Head(ctypes.Structure):
    """``votess_stream_head``."""

    _fields_ = [
        ("seeds", c_uint64),
        ("entries", c_uint64),
        ("duplicates", c_int32),
        ("periodic", c_int32),
        ("box_lower", c_double * 3),
        ("box_upper", c_double * 3),
    ]


# Arrays of rows: type, columns (0: a one-dimensional array), and length: "count" seeds, one "more", or "entries".
ARRAYS: Dict[str, Tuple[Any, int, str]] = {
    "status": (np.uint8, 0, "count"),
    "duplicate_of": (np.int64, 0, "count"),
    "indptr": (np.int64, 0, "more"),
    "indices": (np.int64, 0, "entries"),
    "shifts": (np.int8, 3, "entries"),
    "face_areas": (np.float64, 0, "entries"),
    "face_normals": (np.float64, 3, "entries"),
    "volumes": (np.float64, 0, "count"),
    "centroids": (np.float64, 3, "count"),
    "surface_areas": (np.float64, 0, "count"),
    "security_radii": (np.float64, 0, "count"),
    "face_counts": (np.uint32, 0, "count"),
    "edge_counts": (np.uint32, 0, "count"),
    "vertex_counts": (np.uint32, 0, "count"),
}


class Rows(ctypes.Structure):
    """``votess_stream_rows``."""

    _fields_ = [
        ("first", c_uint64),
        ("count", c_size_t),
        ("entries", c_size_t),
        *((name, c_void_p) for name in ARRAYS),
    ]


# Without the user's pointer unless it is the only argument; see ProgressCallback.
Restart = CFUNCTYPE(c_int, c_void_p)
Next = CFUNCTYPE(c_int, POINTER(Seeds))
Begin = CFUNCTYPE(c_int, POINTER(Head))
Take = CFUNCTYPE(c_int, POINTER(Rows))


class Stream(ctypes.Structure):
    """``votess_stream``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("verify", c_int32),
        ("memory", c_uint64),
        ("temporary", c_char_p),
        ("restart", Restart),
        ("next", Next),
        ("begin", Begin),
        ("rows", Take),
        ("user", c_void_p),
        ("hull", c_int32),
        ("reserved", c_int32),
    ]


class Counts(ctypes.Structure):
    """``votess_stream_counts``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_int32),
        ("blocks", c_uint64),
        ("largest_block", c_uint64),
        ("asked_cells", c_uint64),
        ("temporary_bytes", c_uint64),
        ("passed", c_int32),
        ("checks_skipped", c_uint32),
        ("sampled", c_uint64),
        ("failure", c_char * 256),
    ]


tessellate = lib.votess_tessellate_stream
tessellate.restype, tessellate.argtypes = c_int, (POINTER(Stream), POINTER(Options), POINTER(Counts), POINTER(Stats))
