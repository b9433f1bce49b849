"""Frames into extended XYZ and LAMMPS dumps, as clvotess writes them."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterable, List, Tuple, Union

import numpy as np

from ._arguments import as_path, shown
from ._input import as_points
from .export.whole_file import whole_file
from .frames import Frame

if TYPE_CHECKING:
    import numpy.typing as npt

    Column = Tuple[str, npt.NDArray[Any]]


def _texts(values: npt.NDArray[Any]) -> List[str]:
    """Returns a text for each row: numbers with the fewest digits that read back the same."""
    if values.dtype.kind == "U":
        return list(map(str, values.tolist()))
    if values.dtype.kind == "u" and values.max(initial=0) >= 2**63:
        raise ValueError(f"{values.max()} is a number that the file cannot hold: give numbers below 2**63")
    numbers = values.astype(np.int64 if values.dtype.kind in "iub" else np.float64)
    return [" ".join(map(repr, row)) for row in numbers.reshape(len(numbers), int(np.prod(numbers.shape[1:]))).tolist()]


def _are_words(texts: List[str]) -> bool:
    return all(word.split() == [word] for word in texts)


def _equal(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> bool:
    try:
        return np.array_equal(a.astype(float), b.astype(float))
    except ValueError:
        return np.array_equal(a.astype(str), b.astype(str))


# Readers take the species from the first that is there, see cli/read/columns.hpp.
_SPECIES = ("species", "element", "symbol", "typelabel", "type")
_SPECIES_OF_DUMP = ("element", "typelabel", "species", "symbol", "type")


def _named(frame: Frame, own: List[Column], species: Tuple[str, ...]) -> Dict[str, npt.NDArray[Any]]:
    """Returns the columns of a frame that the file does not write by itself.

    own: those that it writes. species: names that readers look for. Raises ValueError for columns that a line cannot hold,
    for others of the same name, and for those that would be read as species or ids.
    """
    columns = {}
    taken = dict(own)
    before = species[: min(species.index(name) for name in taken if name in species)]
    others = {**dict.fromkeys(before, "species"), "id": "ids"}
    for name, given in frame.columns.items():
        values = np.asarray(given)
        if name in taken and _equal(values, taken[name]):
            continue
        if name in taken:
            raise ValueError(f"frame {frame.number}: the file has a column {name!r} of its own: give this one another name")
        if name in others:
            raise ValueError(f"frame {frame.number}: a column {name!r} would be read as {others[name]}: give it another name")
        if values.ndim not in (1, 2) or len(values) != len(frame) or values.dtype.kind not in "iubfU" or 0 in values.shape[1:]:
            raise ValueError(f"frame {frame.number}: column {name!r} has shape {values.shape}: give {len(frame)} rows of numbers or words")
        if values.dtype.kind == "U" and (values.ndim == 2 or not _are_words(values.tolist())):
            raise ValueError(f"frame {frame.number}: column {name!r} holds texts that are not one word")
        if name.split() != [name] or set(name) & set('":='):
            raise ValueError(f"frame {frame.number}: {name!r} is not a name for a column: leave blanks, quotes, colons and = out")
        columns[name] = values
    return columns


def _edges(frame: Frame) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], List[bool]]:
    """Returns three edges, their corner, and whether the domain repeats. One of the plane gets the height 1 around z = 0.

    Raises ValueError for a domain that the formats cannot state.
    """
    domain = frame.domain
    if domain is None or domain.surface is not None or len(domain.walls) > 0 or (domain.limits is None and domain.vectors is None):
        raise ValueError(f"frame {frame.number}: the file states a box or a cell, and its domain is {domain}: give one in Frame.domain")
    limits, size = domain.limits, frame.points.shape[1]
    if len(domain.periodic) != size:
        raise ValueError(f"frame {frame.number}: points have {size} coordinates, and its domain has {len(domain.periodic)}")
    corner, edges = np.full(3, -0.5), np.eye(3)
    if limits is not None:
        if not np.isfinite(limits).all():
            raise ValueError(f"frame {frame.number}: its box reaches infinity: give bounds")
        # Rounded up where points at the upper bounds would be outside. The error of a difference: Knuth, TAOCP 2, 4.2.2.
        lengths = limits[1] - limits[0]
        parts = lengths - limits[1]
        errors = (limits[1] - (lengths - parts)) - (limits[0] + parts)
        lengths = np.where((errors > 0) & ~np.array(domain.periodic), np.nextafter(lengths, np.inf), lengths)
        corner[:size], edges[:size, :size] = limits[0], np.diag(lengths)
    else:
        corner[:size] = 0 if domain.origin is None else domain.origin
        edges[:size, :size] = domain.vectors
    return edges, corner, [*domain.periodic, False][:3]


def _rows(columns: List[Column]) -> str:
    texts = [_texts(values) for _, values in columns]
    return "".join(" ".join(row) + "\n" for row in zip(*texts))


def _places(frame: Frame) -> npt.NDArray[np.float64]:
    places = np.zeros((len(frame), 3))
    places[:, : frame.points.shape[1]] = frame.points
    return places


def _species(frame: Frame, otherwise: str) -> Tuple[bool, npt.NDArray[Any]]:
    """Returns whether the species are types, and a column of types or elements."""
    words = np.asarray([otherwise] * len(frame) if frame.species is None else frame.species, dtype=str)
    if words.shape != (len(frame),) or not _are_words(words.tolist()):
        raise ValueError(f"frame {frame.number}: species have shape {words.shape}: give {len(frame)} words, without blanks")
    types = [re.fullmatch(r"[+-]?[0-9]+", word) is not None for word in words.tolist()]
    if frame.species is not None and any(types) and not all(types):
        raise ValueError(f"frame {frame.number}: some species are numbers and others are not: give types or elements")
    return frame.species is not None and len(frame) > 0 and all(types), words


def _ids(frame: Frame) -> npt.NDArray[Any]:
    ids = np.asarray(frame.ids)
    if ids.shape != (len(frame),) or ids.dtype.kind not in "iu":
        raise ValueError(f"frame {frame.number}: ids have shape {ids.shape}: give {len(frame)} whole numbers")
    return ids


def _xyz(frame: Frame) -> str:
    edges, corner, periodic = _edges(frame)
    whole, species = _species(frame, "X")
    columns: List[Column] = [("type" if whole else "species", species.astype(np.int64) if whole else species), ("pos", _places(frame))]
    if frame.ids is not None:
        columns.append(("id", _ids(frame)))
    columns += _named(frame, columns, _SPECIES).items()
    kinds = {"i": "I", "u": "I", "b": "I", "f": "R", "U": "S"}
    names = [f"{name}:{kinds[values.dtype.kind]}:{1 if values.ndim == 1 else values.shape[1]}" for name, values in columns]
    step = "" if frame.timestep is None else f" Timestep={frame.timestep:.17g}"
    return (
        f'{len(frame)}\nLattice="{_texts(edges.reshape(1, 9))[0]}" Origin="{_texts(corner.reshape(1, 3))[0]}" '
        f'pbc="{" ".join("FT"[axis] for axis in periodic)}" frame={frame.number}{step} Properties={":".join(names)}\n' + _rows(columns)
    )


def _dump(frame: Frame) -> str:
    edges, corner, periodic = _edges(frame)
    if (edges == np.diag(np.diag(edges))).all() and (np.diag(edges) > 0).all():
        head, box = "", np.stack([corner, corner + np.diag(edges)], axis=1)
        if frame.domain is not None and frame.domain.limits is not None:  # without rounding
            box[: frame.points.shape[1]] = frame.domain.limits.T
    else:
        head, box = " abc origin", np.column_stack([edges, corner])
    flags = "".join(" pp" if axis else " ff" for axis in periodic)
    bounds = "".join(line + "\n" for line in _texts(box))
    whole, species = _species(frame, "1")
    ids = np.arange(1, len(frame) + 1) if frame.ids is None else _ids(frame)
    places = _places(frame)
    columns: List[Column] = [("id", ids), ("type" if whole or frame.species is None else "element", species), ("x y z", places)]
    for name, values in _named(frame, [*columns, *zip("xyz", places.T)], _SPECIES_OF_DUMP).items():
        parts = [name] if values.ndim == 1 else [f"{name}_{k + 1}" for k in range(values.shape[1])]
        columns.append((" ".join(parts), values))
    step = frame.number if frame.timestep is None else frame.timestep
    if not np.isfinite(step) or step != int(step):
        raise ValueError(f"frame {frame.number}: its timestep is {step!r}, and a dump holds whole numbers: change it")
    return (
        f"ITEM: TIMESTEP\n{int(step)}\nITEM: NUMBER OF ATOMS\n{len(frame)}\nITEM: BOX BOUNDS{head}{flags}\n{bounds}"
        f"ITEM: ATOMS {' '.join(name for name, _ in columns)}\n" + _rows(columns)
    )


_FORMATS: Dict[str, Callable[[Frame], str]] = {".xyz": _xyz, ".extxyz": _xyz, ".dump": _dump, ".lammpstrj": _dump}


def write_frames(path: Union[str, os.PathLike[str]], frames: Iterable[Frame]) -> None:
    """Writes frames to a file that OVITO, ASE and :func:`read_frames` read, one after the other, whole or not at all.

    >>> with vt.Tessellator() as tessellator:
    ...     cells = (frame.with_columns(volume=frame.tessellate(tessellator).volumes) for frame in vt.read_frames("run.dump"))
    ...     vt.write_frames("volumes.dump", cells)

    Parameters
    ----------
    path : ``.xyz`` or ``.extxyz`` (extended XYZ), ``.dump`` or ``.lammpstrj`` (LAMMPS).
    frames : may be made one after the other; memory holds one. Their columns are written by name.

    Points of two coordinates get z = 0, and their domain the height 1; ``read_frames(path, planar=True)`` returns two again.

    Raises ValueError for frames without a box or cell, with walls, and for columns or words that a line cannot hold; OSError
    when the file cannot be written.
    """
    file = as_path(path, "path")
    make = _FORMATS.get(os.path.splitext(file)[1].lower())
    if make is None:
        raise ValueError(f"path is {file!r}: known are {' '.join(_FORMATS)}")
    try:
        given = iter(frames)
    except TypeError:
        raise TypeError(f"frames is {shown(frames)}: give Frame objects, one after the other") from None
    with whole_file(file) as name, open(name, "w", encoding="utf-8", newline="\n") as out:
        for frame in given:
            if not isinstance(frame, Frame):
                raise TypeError(f"frames holds something {shown(frame)}: give Frame objects, as read_frames() does")
            points = as_points(frame.points, f"points of frame {frame.number}", planar=True)
            out.write(make(replace(frame, points=points.astype(np.float64, copy=False))))
