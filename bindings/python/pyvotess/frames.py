"""Frames of files. The program clvotess reads them, so each format has one reader."""

from __future__ import annotations

import errno
import itertools
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Dict, Iterable, Iterator, List, Optional, Sequence, Union

import numpy as np

from . import _library
from ._arguments import as_flag, as_path, as_text, counted, shown
from ._call import VotessError
from ._c_api import ErrorCode
from ._domain import SHORT_FORMS, Domain, domain_of
from ._frames_of_hdf5 import frames_of
from .tessellator import Tessellator, tessellate

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array, Int64Array
    from .tessellation import Tessellation


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame of a file: points with their ids and columns, and the domain that the file states."""

    number: int  #: from 0
    points: Float64Array  #: (N, 3), or (N, 2) in two dimensions
    domain: Optional[Domain] = None  #: None if the file states none
    timestep: Optional[float] = None
    ids: Optional[Int64Array] = None  #: (N,), also of a frame without points
    species: Optional[List[str]] = None  #: N elements or types, also of a frame without points
    #: other numbers, (N,) or (N, width), int64 where float64 would round an integer, else float64; words, (N,), of
    #: columns that read_frames() names
    columns: Dict[str, npt.NDArray[Any]] = field(default_factory=dict)
    units: Dict[str, Union[float, str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.number, (int, np.integer)):
            raise TypeError(f"number is {shown(self.number)}: give the frame's number first, as in Frame(0, points)")

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"<pyvotess.Frame {self.number}: {counted(len(self), 'point')}, {'no domain' if self.domain is None else self.domain._text()}>"

    def with_columns(self, **columns: npt.ArrayLike) -> Frame:
        """Returns the frame with further columns, (N,) or (N, width), such as numbers of its cells.

        >>> frame = vt.Frame(0, points, vt.Domain.box(box))
        >>> list(frame.with_columns(volume=t.volumes).columns)
        ['volume']
        """
        return replace(self, columns={**self.columns, **{name: np.asarray(values) for name, values in columns.items()}})

    def tessellate(self, tessellator: Optional[Tessellator] = None, **options: Any) -> Tessellation:
        """Returns the cells in the domain of the file.

        Options are those of :func:`tessellate`. ``domain``, ``box`` and ``cell`` replace the domain, other short forms change
        it.

        >>> vt.Frame(0, points, vt.Domain.box(box)).tessellate(want="volumes")
        <pyvotess.Tessellation of 100 seeds in a box (0, 0, 0) to (1, 1, 1): volumes>
        """
        if self.domain is not None and not {"domain", "box", "cell"} & options.keys():
            short = {name: options.pop(name) for name in SHORT_FORMS if name in options}
            options["domain"] = self.domain.replace(**short)
        run = tessellator.tessellate if tessellator else tessellate
        return run(self.points, **options)


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


def _words(stream: IO[bytes], size: int) -> List[str]:
    """Reads words of so many bytes. Each ends with its line."""
    return _read(stream, np.uint8, size).tobytes().decode("utf-8", "replace").split("\n")[:-1]


def _next_frame(stream: IO[bytes]) -> Optional[Frame]:
    line = stream.readline()
    if not line.endswith(b"\n"):
        return None
    head = json.loads(line)
    count = head["points"]
    points = _read(stream, np.float64, head["dimensions"] * count).reshape(-1, head["dimensions"])
    ids = _read(stream, np.int64, count) if head["ids"] or not count else None
    columns = {}
    for name, width, size, integers in head["columns"]:
        number = np.int64 if integers else np.float64
        values = _read(stream, number, count * width) if width else np.array(_words(stream, size), str)
        columns[name] = values if width < 2 else values.reshape(-1, width)
    species = _words(stream, head["species"])
    domain: Dict[str, Any] = {name: np.array(head[name], float) for name in ("box", "cell", "origin") if name in head}
    if domain or any(head["periodic"]):
        domain["periodic"] = tuple(head["periodic"])
    if head["walls"]:
        domain["walls"] = np.array(head["walls"], float)
    return Frame(
        number=head["frame"],
        points=points,
        domain=domain_of(domain) if domain else None,
        timestep=float(head["timestep"]) if head["timestep"] else None,
        ids=ids,
        species=species if species or not count else None,
        columns=columns,
        units=head["units"],
    )


#: What options of the command line are in Python, the first that fits.
_PYTHON = (
    (r"--radii (\d+), --weights \d+ or --copy \d+", r'columns="\1"'),
    (r"leave --2d out, if x y r, add --radii (\d+)", r'give columns=(), if x y r, columns="\1"'),
    (r"add --radii (\d+)", r'give columns="\1"'),
    (r"; for two dimensions add --2d", '; in two dimensions give coordinates=("1", "2")'),
    (r"add --2d for x and y alone", 'give coordinates=("x", "y") for these alone'),
    (r" with --2d", " in two dimensions"),
    (r"--columns", "coordinates"),
    (r"--copy", "columns"),
    (r"--wall", "walls"),
    (r"--frames?", "frames"),
    (r"--(2d|box|cell|dataset|memory|origin|outside|periodic|radii|weights)\b", r"\1"),
)


def _in_python(message: str, path: str) -> str:
    """Returns a message with the arguments of Python instead of options. Paths and quoted words stay."""
    begin = len(path) if message.startswith(path) else 0
    parts = re.split(r"('[^']*')", message[begin:])
    for k in range(0, len(parts), 2):
        for option, name in _PYTHON:
            parts[k] = re.sub(option, name, parts[k])
    return message[:begin] + "".join(parts)


def _failure(message: str, code: int, path: str) -> Exception:
    message = message.strip()[len("clvotess: ") :] or f"clvotess ended with the code {code}"
    if code != 2:
        return VotessError(message, ErrorCode.INTERNAL)
    unread = re.fullmatch("cannot (?:open|read) '(.*)': (.*)", message)
    for number in (errno.ENOENT, errno.EACCES, errno.EISDIR, errno.ENOTDIR) if unread else ():
        if unread and os.strerror(number) == unread[2]:
            return OSError(number, unread[2], unread[1])  # FileNotFoundError and others
    return ValueError(_in_python(message, path))


def _list_of(names: Iterable[str]) -> str:
    """Returns the names with commas between them, as in .csv."""
    return ",".join('"' + name.replace('"', '""') + '"' if "," in name or name.startswith('"') else name for name in names)


def _frames(command: Sequence[str], path: str) -> Iterator[Frame]:
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
            raise _failure(errors.read().decode("utf-8", "replace"), code, path)


def _columns(given: Sequence[Union[str, int]], name: str) -> List[str]:
    """Returns the names and numbers of columns as texts."""
    if isinstance(given, bytes) or not isinstance(given, Iterable):
        raise TypeError(f"{name} is {shown(given)}: give a list of names or numbers")
    listed = list(given)
    for column in listed:
        if isinstance(column, bool) or not isinstance(column, (str, int, np.integer)):
            raise TypeError(f"{name} has {shown(column)}: give names, or numbers from 1")
    return [str(column) for column in listed]


def read_frames(
    path: Union[str, os.PathLike[str]],
    frames: str = "all",
    dataset: Optional[str] = None,
    columns: Union[str, Sequence[Union[str, int]]] = "all",
    coordinates: Optional[Sequence[Union[str, int]]] = None,
    planar: bool = False,
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
    columns : names of the columns to read, or their numbers from 1; "all" with numbers that have a name.
    coordinates : names or numbers of the columns of x, y and perhaps z, in rows of text, .npz, .ply and LAMMPS dumps.
    planar : points (N, 2) and a domain of the plane, from a file whose points have one z, as :func:`write_frames` makes it.

    Raises ValueError for a file that cannot be read, FileNotFoundError without one, ImportError without ``clvotess``, or
    without h5py for HDF5 where ``clvotess`` lacks it, as in a wheel.
    """
    file = as_path(path, "path")
    if file.startswith("-"):  # not an option, nor the input of the program
        file = os.path.join(os.curdir, file)
    as_text(frames, "frames")
    if dataset is not None:
        as_text(dataset, "dataset")
    names = _columns([columns] if isinstance(columns, str) else columns, "columns")
    command = [_program(), file, "--points"]
    for option, value in (
        ("--frames", frames),
        ("--dataset", dataset),
        ("--copy", _list_of(names) if names else None),
        ("--columns", None if coordinates is None else _list_of(_columns(coordinates, "coordinates"))),
    ):
        if value is not None:  # joined, for it may begin with a minus sign
            command += [f"{option}={value}"] if value else [option, value]
    if as_flag(planar, "planar"):
        command.append("--2d")
    found = _frames(command, file)
    try:
        first = next(found)  # errors of the file are raised here
    except ValueError as error:
        if planar or "the module for HDF5 cannot be loaded" not in str(error):  # as in a wheel
            raise
        found = (Frame(**parts) for parts in frames_of(file, frames, dataset, names))
        first = next(found)
    return itertools.chain((first,), found)
