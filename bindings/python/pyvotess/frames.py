"""Frames of files. The program clvotess reads them, so each format has one reader."""

from __future__ import annotations

import itertools
import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Sequence, Union

import numpy as np

from . import _library
from ._call import VotessError
from ._c_api import ErrorCode
from .tessellator import Tessellator, tessellate

if TYPE_CHECKING:
    import numpy.typing as npt

    from .tessellation import Tessellation

    Float64Array = npt.NDArray[np.float64]
    Int64Array = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Frame:
    """A frame of a file: points with their ids and columns, and the domain that the file states."""

    number: int  #: from 0
    points: Float64Array  #: (N, 3), or (N, 2) in two dimensions
    #: the arguments box, cell, origin, periodic and walls of :func:`tessellate`; empty if the file states none
    domain: Dict[str, Any] = field(default_factory=dict)
    timestep: Optional[float] = None
    ids: Optional[Int64Array] = None  #: (N,)
    species: Optional[List[str]] = None  #: N elements or types
    columns: Dict[str, Float64Array] = field(default_factory=dict)  #: other numbers, (N,) or (N, width)
    units: Dict[str, Union[float, str]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<pyvotess.Frame {self.number}: {len(self)} points, {', '.join(self.domain) or 'no domain'}>"

    def tessellate(self, tessellator: Optional[Tessellator] = None, **options: Any) -> Tessellation:
        """Returns the cells in the domain of the file. Options are those of :func:`tessellate`, and override it."""
        given = {} if {"box", "cell"} & options.keys() else self.domain
        run = tessellator.tessellate if tessellator else tessellate
        return run(self.points, **{**given, **options})


def _program() -> str:
    """Returns the path of clvotess: beside the library, or on the system's path."""
    name = "clvotess.exe" if sys.platform == "win32" else "clvotess"
    library = Path(_library.path)
    beside = library.resolve().parent.parent / "bin" / name if library.parent != Path(".") else Path(name)
    found = str(beside) if beside.is_file() else shutil.which("clvotess")
    if found is None:
        raise ImportError(f"read_frames() needs the program clvotess, and there is none at {beside}: build or install it")
    return found


def _read(stream: IO[bytes], dtype: Any, count: int) -> npt.NDArray[Any]:
    array = np.empty(count, dtype)
    view = array.view(np.uint8)
    done = 0
    while done < len(view):
        got = stream.readinto(view[done:])  # type: ignore[attr-defined]
        if not got:
            raise EOFError
        done += got
    return array


def _next_frame(stream: IO[bytes]) -> Optional[Frame]:
    line = stream.readline()
    if not line.endswith(b"\n"):
        return None
    head = json.loads(line)
    count = head["points"]
    points = _read(stream, np.float64, head["dimensions"] * count).reshape(-1, head["dimensions"])
    ids = _read(stream, np.int64, count) if head["ids"] else None
    columns = {}
    for name, width in head["columns"]:
        values = _read(stream, np.float64, count * width)
        columns[name] = values if width == 1 else values.reshape(-1, width)
    words = _read(stream, np.uint8, head["species"]).tobytes().decode("utf-8", "replace")
    domain: Dict[str, Any] = {name: np.array(head[name], float) for name in ("box", "cell", "origin") if name in head}
    if domain or any(head["periodic"]):
        domain["periodic"] = tuple(head["periodic"])
    if head["walls"]:
        domain["walls"] = np.array(head["walls"], float)
    return Frame(
        number=head["frame"],
        points=points,
        domain=domain,
        timestep=float(head["timestep"]) if head["timestep"] else None,
        ids=ids,
        species=words.split(" ") if words else None,
        columns=columns,
        units=head["units"],
    )


def _failure(message: str, code: int) -> Exception:
    message = message.strip()[len("clvotess: ") :] or f"clvotess ended with the code {code}"
    return ValueError(message) if code == 2 else VotessError(message, ErrorCode.INTERNAL)


def _frames(command: Sequence[str]) -> Iterator[Frame]:
    with tempfile.TemporaryFile() as errors:
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, stdin=subprocess.DEVNULL) as process:
            assert process.stdout is not None
            try:
                while True:
                    try:
                        frame = _next_frame(process.stdout)
                    except EOFError:
                        frame = None
                    if frame is None:
                        break
                    yield frame
                code = process.wait()
            finally:
                process.kill()
        if code != 0:
            errors.seek(0)
            raise _failure(errors.read().decode("utf-8", "replace"), code)


def read_frames(
    path: Union[str, os.PathLike[str]],
    frames: str = "all",
    dataset: Optional[str] = None,
    columns: Union[str, Sequence[str]] = "all",
) -> Iterator[Frame]:
    """Returns an iterator over the frames of a file, in one pass, with memory for few frames.

    The program ``clvotess`` reads the file: extended XYZ, LAMMPS dumps, H5MD and MDTraj's HDF5. Another file is one
    frame.

    >>> with vt.Tessellator() as tessellator:
    ...     for frame in vt.read_frames("run.dump"):
    ...         volumes = frame.tessellate(tessellator).volumes

    Parameters
    ----------
    frames : "all", "last" or "a:b:c", frames a to b - 1 in steps of c, counted from 0.
    dataset : of .h5 or .npz; default: the only one that fits.
    columns : names of the columns to read, or "all" with numbers that have a name.

    Raises ValueError for a file that cannot be read, ImportError without ``clvotess``.
    """
    command = [_program(), os.fspath(path), "--frames", frames, "--points"]
    if dataset is not None:
        command += ["--dataset", dataset]
    names = [columns] if isinstance(columns, str) else list(columns)
    if names:
        command += ["--copy", ",".join(names)]
    found = _frames(command)
    first = next(found)  # errors of the file are raised here
    return itertools.chain((first,), found)
