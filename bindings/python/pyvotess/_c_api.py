"""The C interface of votess for ctypes: constants, structs and a table of signatures (votess/votess.h)."""

from __future__ import annotations

import ctypes
from ctypes import (
    CFUNCTYPE,
    POINTER,
    c_char,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_int64,
    c_size_t,
    c_uint32,
    c_uint64,
    c_uint8,
    c_void_p,
)
from enum import IntEnum
from typing import Any, Dict, Literal, Tuple

OK = 0


class ErrorCode(IntEnum):
    """Why a call failed; the values of ``votess_status`` in C."""

    INVALID_ARGUMENT = 1
    OUT_OF_MEMORY = 2
    CANCELLED = 3
    UNSUPPORTED = 4
    INTERNAL = 5
    DEVICE_LOST = 6  #: the device stopped responding or its driver failed
    INVALID_USE = 7  #: the Tessellator is in use by another call
    STORAGE = 8  #: temporary files of :func:`tessellate_stream` cannot be written, for example on a full disk
    NO_THREADS = 9  #: the system provides fewer threads than requested
    NOT_CONVERGED = 10  #: :func:`fit_volumes` did not reach the tolerance


class CellStatus(IntEnum):
    """One byte for each cell. Results hold only ``CERTIFIED``, ``DUPLICATE``, ``EMPTY`` and ``OUTSIDE``."""

    CERTIFIED = 0  #: proven complete, every sign certain
    NEEDS_EXACT = 1  #: a sign could not be certified in floating point
    PLANE_OVERFLOW = 2  #: more planes than the engine's storage holds
    VERTEX_OVERFLOW = 3  #: more vertices than the engine's storage holds
    CANDIDATES_EXHAUSTED = 4  #: the candidate list ended before the security radius
    DUPLICATE = 5  #: empty: a seed of lower index has the same coordinates and keeps the cell
    EMPTY = 6  #: the cell has no interior
    OUTSIDE = 7  #: the seed lies outside the domain


WANT_BITS: Dict[str, int] = {
    "neighbors": 1,
    "volumes": 2,
    "centroids": 4,
    "counts": 8,
    "areas": 16,
    "normals": 32,
    "surfaces": 64,
    "radii": 128,
    "vertices": 256,
    "faces": 512,
}
DUPLICATES: Dict[str, int] = {"merge": 0, "error": 1}
OUTSIDE: Dict[str, int] = {"error": 0, "drop": 1, "keep": 2}
PRECISIONS: Dict[str, int] = {"single": 0, "double": 1}
#: Options whose value is a word.
WORDS: Dict[str, Dict[str, int]] = {"duplicates": DUPLICATES, "outside": OUTSIDE, "precision": PRECISIONS}
NATURAL_METHODS: Dict[str, int] = {"sibson": 0, "laplace": 1}
GRID_METHODS: Dict[str, int] = {"mean": 0, "dtfe": 1, "nearest": 2, "sibson": 3}
WantWord = Literal[
    "neighbors", "volumes", "centroids", "counts", "areas", "normals", "surfaces", "radii", "vertices", "faces"
]
#: Names that ``want`` accepts: words, and the arrays in their groups.
WantName = Literal[
    WantWord,
    "indptr", "indices", "shifts", "face_areas", "face_normals", "surface_areas", "mesh_areas", "security_radii",
    "face_counts",
    "edge_counts", "vertex_counts", "cell_vertices", "cell_vertex_indptr", "cell_vertex_indices", "face_offsets",
    "face_vertices", "status", "duplicate_of", "ids",
]  # fmt: skip
DuplicatesWord = Literal["merge", "error"]
OutsideWord = Literal["error", "drop", "keep"]
RepairWord = Literal["merge"]
PrecisionWord = Literal["single", "double"]
NaturalWord = Literal["sibson", "laplace"]
BeyondWord = Literal["nan", "nearest"]
GridWord = Literal["mean", "dtfe", "nearest", "sibson"]
CHECK_BITS: Dict[str, int] = {"volumes": 1, "symmetry": 2, "euler": 4, "sample": 8}
SAMPLE_AUTOMATIC = ctypes.c_size_t(-1).value

# Callbacks omit their last argument, the user's pointer; the calling convention of C allows it.
ProgressCallback = CFUNCTYPE(c_int, c_double)
LogCallback = CFUNCTYPE(None, c_char_p, c_void_p)


class Options(ctypes.Structure):
    """``votess_options``; tools/options.py writes the fields that are one number, word or text."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("want", c_uint32),
        ("list_walls", c_int32),
        ("has_box", c_int32),
        ("box_lower", c_double * 3),
        ("box_upper", c_double * 3),
        ("periodic", c_int32 * 3),
        ("has_cell", c_int32),
        ("cell_origin", c_double * 3),
        ("cell_a", c_double * 3),
        ("cell_b", c_double * 3),
        ("cell_c", c_double * 3),
        ("cell_periodic", c_int32 * 3),
        ("walls", c_void_p),
        ("wall_count", c_uint64),
        ("weights", c_void_p),
        ("radii", c_void_p),
        ("min_face", c_double),
        ("min_area", c_double),
        ("outside", c_int32),
        ("duplicates", c_int32),
        ("device", c_char_p),
        ("precision", c_int32),
        ("threads", c_uint32),
        ("grid_resolution", c_uint32),
        ("k_init", c_uint32),
        ("chunk_size", c_uint32),
        ("follow", c_int32),
        ("instructions", c_char_p),
        ("progress", ProgressCallback),
        ("progress_user", c_void_p),
        ("log", LogCallback),
        ("log_user", c_void_p),
        ("planar", c_int32),
        ("has_only", c_int32),
        ("only_count", c_uint64),
        ("only", c_void_p),
        ("has_mesh", c_int32),
        ("mesh_merge", c_int32),
        ("mesh_vertex_count", c_uint64),
        ("mesh_vertices", c_void_p),
        ("mesh_triangle_count", c_uint64),
        ("mesh_triangles", c_void_p),
        ("mesh_tolerance", c_double),
    ]


class Array(ctypes.Structure):
    """``votess_array``."""

    _fields_ = [
        ("data", c_void_p),
        ("length", c_size_t),
        ("components", c_size_t),
        ("kind", c_char),
        ("bytes", c_uint8),
    ]


class Stats(ctypes.Structure):
    """``votess_stats``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("points", c_uint64),
        ("faces", c_uint64),
        ("duplicates", c_uint64),
        ("empty_cells", c_uint64),
        ("fallback_cells", c_uint64),
        ("exact_cells", c_uint64),
        ("peak_memory_bytes", c_uint64),
        ("mean_faces", c_double),
        ("volume_sum", c_double),
        ("box_volume", c_double),
        ("seconds_upload", c_double),
        ("seconds_sort", c_double),
        ("seconds_knn", c_double),
        ("seconds_clip", c_double),
        ("seconds_fallback", c_double),
        ("seconds_download", c_double),
        ("seconds_total", c_double),
        ("precision", c_int32),
        ("device", c_char * 252),
        ("fallback_uncertain", c_uint64),
        ("fallback_overflow", c_uint64),
        ("fallback_exhausted", c_uint64),
        ("fallback_skipped", c_uint64),
        ("fallback_domain", c_uint64),
        ("tiny_faces", c_int64),
        ("seconds_open", c_double),
        ("moved_vertices", c_uint64),
        ("moved_distance", c_double),
        ("kept_cells", c_uint64),
    ]


class FitOptions(ctypes.Structure):
    """``votess_fit_options``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("max_steps", c_uint32),
        ("tolerance", c_double),
        ("normalize", c_int32),
        ("reserved", c_int32),
        ("density", c_void_p),
        ("density_shape", c_size_t * 3),
    ]


class FitStats(ctypes.Structure):
    """``votess_fit_stats``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("steps", c_uint32),
        ("tessellations", c_uint32),
        ("reserved", c_uint32),
        ("residual", c_double),
        ("seconds_tessellate", c_double),
        ("seconds_assemble", c_double),
        ("seconds_solve", c_double),
        ("seconds_total", c_double),
    ]


class Column(ctypes.Structure):
    """``votess_column``."""

    _fields_ = [
        ("name", c_char_p),
        ("values", c_void_p),
        ("width", c_uint64),
        ("kind", c_char),
        ("bytes", c_uint8),
    ]


class Mesh(ctypes.Structure):
    """``votess_mesh``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("column_count", c_uint32),
        ("cells", c_uint64),
        ("vertex_count", c_uint64),
        *((name, c_void_p) for name in (
            "indptr", "indices", "shifts", "face_offsets", "face_vertices", "vertices", "cell_vertex_indptr",
            "cell_vertex_indices", "colors",
        )),
        ("columns", POINTER(Column)),
        ("box_lower", c_double * 3),
        ("box_upper", c_double * 3),
        ("planar", c_int32),
        ("skip_open", c_int32),
        ("left_out", c_void_p),
        ("edges", c_double * 9),
        ("seeds", c_void_p),
        ("weights", c_void_p),
        ("min_edge", c_double),
        ("short_edges", c_void_p),
    ]  # fmt: skip


class MeshQuality(ctypes.Structure):
    """``votess_mesh_quality``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("cells", c_uint64),
        ("faces", c_uint64),
        ("internal_faces", c_uint64),
        ("vertices", c_uint64),
        ("max_non_orthogonality", c_double),
        ("mean_non_orthogonality", c_double),
        ("severe_faces", c_uint64),
        ("max_skewness", c_double),
        ("skew_faces", c_uint64),
        ("min_area", c_double),
        ("min_volume", c_double),
        ("min_edge", c_double),
        ("wrong_faces", c_uint64),
        ("wrong_cells", c_uint64),
        ("short_edges", c_uint64),
    ]


class Bytes(ctypes.Structure):
    """``votess_bytes``."""

    _fields_ = [("data", c_void_p), ("count", c_size_t), ("total", c_uint64), ("file", c_char_p)]


WriteCallback = CFUNCTYPE(c_int, POINTER(Bytes))


class SurfaceOptions(ctypes.Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("threads", c_uint32),
        ("weights", c_void_p),
        ("tolerance", c_double),
        ("merge", c_int32),
        ("reserved", c_int32),
        ("progress", ProgressCallback),
        ("user", c_void_p),
    ]


class PieceArrays(ctypes.Structure):
    """``votess_piece_arrays``."""

    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("rows", c_uint64),
        ("indptr", c_void_p),
        ("ids", c_void_p),
        ("vertex_offsets", c_void_p),
        ("vertices", c_void_p),
        ("triangle_offsets", c_void_p),
        ("triangles", c_void_p),
        ("on_surface", c_void_p),
        ("centroids", c_void_p),
        ("sources", c_void_p),
    ]


# Handles are void pointers.
_HANDLE = c_void_p
_ARRAY = (c_int, (_HANDLE, c_char_p, POINTER(Array)))

# name: (type of the result, types of the arguments), in the order of votess.h.
SIGNATURES: Dict[str, Tuple[Any, Tuple[Any, ...]]] = {
    "votess_set_progress": (None, (ProgressCallback, c_void_p)),
    "votess_version": (c_uint32, ()),
    "votess_version_string": (c_char_p, ()),
    "votess_sizeof_options": (c_size_t, ()),
    "votess_sizeof_stats": (c_size_t, ()),
    "votess_last_error": (c_char_p, ()),
    "votess_options_init": (c_int, (POINTER(Options), c_size_t)),
    "votess_want_of": (c_int, (c_char_p, POINTER(c_uint32))),
    "votess_options_implied_want": (c_int, (POINTER(Options), POINTER(c_uint32))),
    "votess_tessellator_new": (c_int, (POINTER(_HANDLE),)),
    "votess_tessellator_free": (None, (_HANDLE,)),
    "votess_tessellate": (c_int, (_HANDLE, c_void_p, c_size_t, POINTER(Options), POINTER(_HANDLE))),
    "votess_tessellate_f32": (c_int, (_HANDLE, c_void_p, c_size_t, POINTER(Options), POINTER(_HANDLE))),
    "votess_result_free": (None, (_HANDLE,)),
    "votess_result_size": (c_size_t, (_HANDLE,)),
    "votess_result_array": _ARRAY,
    "votess_result_in_mesh": (c_int, (_HANDLE,)),
    "votess_result_planar": (c_int, (_HANDLE,)),
    "votess_result_lists_walls": (c_int, (_HANDLE,)),
    "votess_result_least_face": (c_double, (_HANDLE,)),
    "votess_result_box": (c_int, (_HANDLE, POINTER(c_double), POINTER(c_double))),
    "votess_result_periodic": (c_int, (_HANDLE, POINTER(c_int32))),
    "votess_result_cell": (c_int, (_HANDLE, POINTER(c_int32), *(POINTER(c_double),) * 4)),
    "votess_result_stats": (c_int, (_HANDLE, POINTER(Stats))),
    "votess_delaunay_new": (c_int, (_HANDLE, POINTER(_HANDLE))),
    "votess_delaunay_free": (None, (_HANDLE,)),
    "votess_delaunay_array": _ARRAY,
    "votess_diagram_new": (c_int, (c_void_p, c_size_t, POINTER(Options), POINTER(_HANDLE))),
    "votess_diagram_view": (c_int, (_HANDLE, POINTER(Options), POINTER(_HANDLE))),
    "votess_diagram_free": (None, (_HANDLE,)),
    "votess_diagram_size": (c_size_t, (_HANDLE,)),
    "votess_diagram_planar": (c_int, (_HANDLE,)),
    "votess_diagram_locate": (c_int, (_HANDLE, c_void_p, c_size_t, c_void_p)),
    "votess_diagram_probe": (
        c_int,
        (_HANDLE, c_void_p, c_size_t, c_uint32, c_int32, c_void_p, POINTER(_HANDLE)),
    ),
    "votess_rays_new": (c_int, (_HANDLE, c_void_p, c_void_p, c_void_p, c_size_t, c_int32, POINTER(_HANDLE))),
    "votess_rays_free": (None, (_HANDLE,)),
    "votess_rays_array": _ARRAY,
    "votess_natural_new": (
        c_int,
        (_HANDLE, c_void_p, c_size_t, c_int32, c_int32, c_int32, c_void_p, POINTER(_HANDLE)),
    ),
    "votess_natural_free": (None, (_HANDLE,)),
    "votess_natural_array": _ARRAY,
    "votess_diagram_interpolate": (
        c_int,
        (_HANDLE, c_void_p, c_size_t, c_void_p, c_size_t, c_int32, c_int32, c_void_p, c_void_p, c_void_p),
    ),
    "votess_diagram_to_grid": (
        c_int,
        (_HANDLE, c_void_p, c_size_t, POINTER(c_size_t), c_int32, c_int32, c_void_p, POINTER(c_size_t)),
    ),
    "votess_fit_options_init": (c_int, (POINTER(FitOptions), c_size_t)),
    "votess_fit_volumes": (
        c_int,
        (c_void_p, c_size_t, c_void_p, POINTER(Options), POINTER(FitOptions), POINTER(_HANDLE)),
    ),
    "votess_fit_free": (None, (_HANDLE,)),
    "votess_fit_array": _ARRAY,
    "votess_fit_get_stats": (c_int, (_HANDLE, POINTER(FitStats))),
    "votess_fit_result": (c_int, (_HANDLE, POINTER(_HANDLE))),
    "votess_zones_new": (c_int, (_HANDLE, c_void_p, c_size_t, c_int32, POINTER(_HANDLE))),
    "votess_zones_merge": (c_int, (_HANDLE, c_double, POINTER(_HANDLE))),
    "votess_zones_free": (None, (_HANDLE,)),
    "votess_zones_array": _ARRAY,
    "votess_groups_new": (c_int, (_HANDLE, c_void_p, c_size_t, POINTER(_HANDLE))),
    "votess_groups_free": (None, (_HANDLE,)),
    "votess_groups_array": _ARRAY,
    "votess_masses_new": (c_int, (_HANDLE, c_void_p, c_size_t * 3, c_uint32, POINTER(_HANDLE))),
    "votess_masses_free": (None, (_HANDLE,)),
    "votess_masses_array": _ARRAY,
    "votess_network_new": (c_int, (_HANDLE, c_void_p, c_size_t, POINTER(_HANDLE))),
    "votess_network_free": (None, (_HANDLE,)),
    "votess_network_array": _ARRAY,
    "votess_network_largest_included": (c_int, (_HANDLE, POINTER(c_double), POINTER(c_int32))),
    "votess_network_largest_free": (
        c_int,
        (_HANDLE, c_int32, POINTER(c_double), POINTER(c_int32), POINTER(c_double), POINTER(c_int32)),
    ),
    "votess_pieces_new": (c_int, (_HANDLE, c_double, c_uint32, ProgressCallback, c_void_p, POINTER(_HANDLE))),
    "votess_pieces_free": (None, (_HANDLE,)),
    "votess_pieces_array": _ARRAY,
    "votess_alpha_new": (c_int, (_HANDLE, c_void_p, c_size_t, c_void_p, POINTER(_HANDLE))),
    "votess_alpha_free": (None, (_HANDLE,)),
    "votess_alpha_array": (c_int, (_HANDLE, c_int32, c_char_p, POINTER(Array))),
    "votess_verify": (
        c_int,
        (
            _HANDLE,
            c_void_p,
            c_size_t,
            c_size_t,
            c_uint64,
            POINTER(c_int),
            POINTER(c_int),
            POINTER(c_uint32),
            POINTER(c_size_t),
            c_char_p,
            c_size_t,
        ),
    ),
    "votess_count_tiny_faces": (c_int32, (_HANDLE, c_void_p, c_size_t, POINTER(c_uint64))),
    "votess_wrapped_points": (c_int, (_HANDLE, c_void_p, c_size_t, c_void_p)),
    "votess_value_colors": (c_int, (c_void_p, c_size_t, c_int32, c_void_p)),
    "votess_write_mesh": (c_int, (POINTER(Mesh), c_char_p, WriteCallback, c_void_p)),
    "votess_measure_mesh": (c_int, (POINTER(Mesh), POINTER(MeshQuality))),
    "votess_write_pieces": (c_int, (POINTER(PieceArrays), c_char_p, WriteCallback, c_void_p)),
    "votess_sphere_walls": (c_int, (c_void_p, c_double, c_size_t, c_void_p)),
    "votess_cylinder_walls": (c_int, (c_void_p, c_void_p, c_double, c_size_t, c_void_p)),
    "votess_cone_walls": (c_int, (c_void_p, c_void_p, c_double, c_size_t, c_void_p)),
    "votess_hull_new": (c_int, (c_void_p, c_size_t, POINTER(Options), POINTER(_HANDLE))),
    "votess_hull_free": (None, (_HANDLE,)),
    "votess_hull_array": _ARRAY,
    "votess_device_count": (c_size_t, ()),
    "votess_device_info": (c_int, (c_size_t, c_char_p, c_size_t, c_char_p, c_size_t, c_char_p, c_size_t)),
    # votess/surface.h
    "votess_surface_new": (
        c_int,
        (c_void_p, c_size_t, c_void_p, c_size_t, c_void_p, c_size_t, POINTER(SurfaceOptions), POINTER(_HANDLE)),
    ),
    "votess_surface_free": (None, (_HANDLE,)),
    "votess_surface_array": _ARRAY,
}


def declare(library: ctypes.CDLL, signatures: Dict[str, Tuple[Any, Tuple[Any, ...]]] = SIGNATURES) -> None:
    """Sets the signatures of these functions. Raises AttributeError when the library lacks one."""
    for name, signature in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = signature
