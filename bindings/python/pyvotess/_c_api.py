"""The C interface of votess for ctypes: structs, functions and constants, read from its headers."""

from __future__ import annotations

import ctypes
import re
from ctypes import CFUNCTYPE, POINTER, c_char, c_char_p, c_void_p
from enum import IntEnum
from pathlib import Path
from typing import Any, Dict, Iterator, Literal, Tuple

import numpy as np

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


class _Numbers:
    """A pointer to numbers: takes an array, which must have their type, a number of ctypes, an address, or None."""

    def __init__(self, kind: Any) -> None:
        self._dtype: np.dtype[Any] = np.dtype(kind)

    def from_param(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            if value.dtype != self._dtype or not value.flags.c_contiguous:
                raise TypeError(f"the library reads {self._dtype} in C order, not {value.dtype}")
            return c_void_p(value.ctypes.data)
        if isinstance(value, ctypes._SimpleCData):
            return ctypes.byref(value)
        return c_void_p.from_param(value)


class _New:
    """A pointer to the pointer of a handle, which the library sets."""

    @staticmethod
    def from_param(value: Any) -> Any:
        return ctypes.byref(value.pointer) if hasattr(value, "pointer") else c_void_p.from_param(value)


class Struct(ctypes.Structure):
    """A struct of the library, which knows its size. An array that is set in place of a pointer lives as long."""

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        if hasattr(type(self), "struct_size"):
            self.struct_size = ctypes.sizeof(self)

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(value, np.ndarray):
            vars(self)[name] = value
            value = value.ctypes.data if value.size else None
        super().__setattr__(name, value)


#: Types of C by name: of numbers, of structs and of callbacks. Other names are those of handles.
_TYPES: Dict[str, Any] = {
    "votess_status": ctypes.c_int,
    **{name: getattr(ctypes, "c_" + name) for name in ("char", "int", "float", "double", "size_t")},
    **{f"{kind}{bits}_t": getattr(ctypes, f"c_{kind}{bits}") for kind in ("int", "uint") for bits in (8, 16, 32, 64)},
}


def read_headers(*names: str) -> str:
    """Returns the text of headers without comments. They are in a wheel, or in the source tree around the package."""
    package = Path(__file__).resolve().parent
    folders = [parent / "include" / "votess" for parent in (package, *list(package.parents)[2:3])]
    for folder in folders:
        if (folder / names[0]).is_file():
            return re.sub("//.*", "", "".join((folder / name).read_text("utf-8") for name in names))
    raise ImportError(f"{names[0]} was not found in {' nor in '.join(map(str, folders))}: install pyvotess with its headers")


def _value(kind: str, pointer: str) -> Any:
    """Returns the type of a value, as in structs."""
    known = _TYPES.get(kind, c_void_p)
    if not pointer:
        return known
    return c_char_p if known is c_char else POINTER(known) if issubclass(known, ctypes.Structure) else c_void_p


def _argument(text: str) -> Any:
    """Returns the type of an argument. Pointers to numbers take arrays, those of handles take objects that have one."""
    kind, pointer, brackets = re.fullmatch(r"(?:const )?(\w+)(\**) \w+((?:\[\d\])?)", text).groups()  # type: ignore[union-attr]
    if pointer == "**":
        return _New
    if (pointer or brackets) and kind != "char" and issubclass(_TYPES.get(kind, c_void_p), ctypes._SimpleCData) and kind in _TYPES:
        return _Numbers(_TYPES[kind])
    return _value(kind, pointer)


def _arguments(text: str) -> Iterator[str]:
    return (part for part in " ".join(text.split()).split(", ") if part != "void")


def _callback(result: str, arguments: str) -> Any:
    """Returns the type of a callback, without its last argument, the user's pointer. The calling convention of C allows it."""
    kinds = [re.sub("^const ", "", part).partition(" ")[0] for part in _arguments(arguments)]
    types = [_value(kind.rstrip("*"), "*" * kind.count("*")) for kind in kinds]
    return CFUNCTYPE(_TYPES.get(result), *types[: max(1, len(types) - 1)])


def _fields(text: str) -> Iterator[Tuple[str, Any]]:
    for part in text.split(";"):
        line = " ".join(part.split())
        callback = re.fullmatch(r"(\w+) \(\*(\w+)\)\((.*)\)", line)
        member = re.fullmatch(r"(?:const )?(\w+)(\*?) (.*)", line)
        if callback:
            yield callback[2], _callback(callback[1], callback[3])
        elif member:
            for name, size in re.findall(r"(\w+)(?:\[(\d+)\])?", member[3]):
                kind = _value(member[1], member[2])
                yield name, kind * int(size) if size else kind


def read_types(text: str) -> Dict[str, Any]:
    """Returns the structs and callbacks that headers define: MeshQuality is votess_mesh_quality."""
    found = {}
    typedef = r"typedef struct (\w+) \{(.*?)\n\} \w+;|typedef (\w+) \(\*(\w+)\)\((.*?)\);"
    for struct, body, result, callback, given in re.findall(typedef, text, re.S):
        name = "".join(word.capitalize() for word in (struct or callback).split("_")[1:])
        members = {"__doc__": f"``{struct}``.", "_fields_": list(_fields(body))}
        found[name] = type(name, (Struct,), members) if struct else _callback(result, given)
        _TYPES[struct or callback] = found[name]
    return found


def signatures(text: str, **types: Any) -> Dict[str, Tuple[Any, Tuple[Any, ...]]]:
    """Returns for each function of headers the types of its result and of its arguments. types: others, by name."""
    _TYPES.update(types)
    found = re.findall(r"^VOTESS_API (?:const )?(\w+\*?) (\w+)\((.*?)\);", text, re.S | re.M)
    return {
        name: (c_char_p if result == "char*" else _TYPES.get(result), tuple(map(_argument, _arguments(arguments))))
        for result, name, arguments in found
    }


_TEXT = read_headers("votess.h", "surface.h", "picture.h", "stream.h", "frames.h")


_CONSTANTS = re.findall(r"\bVOTESS_([A-Z]+)_(\w+) (?:= )?(\d+)", _TEXT)


def _words(kind: str) -> Dict[str, int]:
    """Returns the constants VOTESS_<kind>_<word>."""
    return {word.lower(): int(value) for of, word, value in _CONSTANTS if of == kind}


CHECK_BITS = _words("CHECK")
DUPLICATES, OUTSIDE, PRECISIONS = _words("DUPLICATES"), _words("OUTSIDE"), _words("PRECISION")
#: Options whose value is a word.
WORDS: Dict[str, Dict[str, int]] = {"duplicates": DUPLICATES, "outside": OUTSIDE, "precision": PRECISIONS}
NATURAL_METHODS: Dict[str, int] = {"sibson": 0, "laplace": 1}
GRID_METHODS: Dict[str, int] = {"mean": 0, "dtfe": 1, "nearest": 2, "sibson": 3}
SAMPLE_AUTOMATIC = ctypes.c_size_t(-1).value
TINY_FACES_UNKNOWN = 2**64 - 1
DuplicatesWord = Literal["merge", "error"]
OutsideWord = Literal["error", "drop", "keep"]
RepairWord = Literal["merge"]
PrecisionWord = Literal["single", "double"]
NaturalWord = Literal["sibson", "laplace"]
BeyondWord = Literal["nan", "nearest"]
GridWord = Literal["mean", "dtfe", "nearest", "sibson"]


_DEFINED = read_types(_TEXT)
#: Of each function the types of the result and of the arguments, in the order of the headers.
SIGNATURES = signatures(_TEXT)


def __getattr__(name: str) -> Any:
    """Returns a struct or callback of the headers."""
    if name not in _DEFINED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _DEFINED[name]


def declare(library: ctypes.CDLL, signatures: Dict[str, Tuple[Any, Tuple[Any, ...]]] = SIGNATURES) -> None:
    """Sets the signatures of these functions. Raises AttributeError when the library lacks one."""
    for name, signature in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = signature
