"""Frames of HDF5 by h5py, for a clvotess without HDF5 such as that of the wheels. The rules are those of clvotess."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from ._domain import Domain, domain_of

if TYPE_CHECKING:
    import numpy.typing as npt

_VECTORS = set("velocities velocity vel v forces force f accelerations acceleration magneticfield momenta".split())
_IDS = ("ParticleIDs", "ids", "id/value", "id")


def _stem(path: str) -> str:
    """Returns the path of an element of H5MD, which is a group with the dataset ``value``."""
    return path[: -len("/value")] if path.endswith("/value") else path


def _points(file: Any, group: str, where: str) -> str:
    """Returns the path of the only dataset of a group that can be the points."""
    found: Dict[int, List[str]] = {3: [], 2: []}

    def visit(path: str, item: Any) -> None:
        shape: Tuple[int, ...] = getattr(item, "shape", None) or ()
        name = _stem(path).rsplit("/", 1)[-1].lower()
        vectors = len(shape) in (2, 3) and item.dtype.kind == "f" and shape[-1] in found
        if vectors and path.startswith(group) and name not in _VECTORS and path != "walls" and not _stem(path).endswith("/box/edges"):
            found[shape[-1]].append(path)

    file.visititems(visit)
    paths = found[3] or found[2]
    usual = [p for p in paths if p.endswith("position/value") or p.rsplit("/", 1)[-1].lower() in ("coordinates", "positions")]
    if len(usual) == 1 or len(paths) == 1:
        return (usual if len(usual) == 1 else paths)[0]
    if not paths:
        raise ValueError(f"{where}: no dataset of floats with shape (N, 3) or (N, 2): store the coordinates as one, "
                         "or as the arrays x, y, z of an .npz")
    raise ValueError(f"{where}: several datasets could be the points, name one with dataset: {' '.join(paths[:8])}")


def _whole(values: npt.NDArray[Any], where: str, absent: Optional[int] = None) -> npt.NDArray[np.int64]:
    """Returns int64. absent: of particles that are not there, of any size."""
    if values.dtype.kind == "u":
        large = values[(values >= 2**63) & (True if absent is None else values != absent)]
        if large.size:
            raise ValueError(f"{where} has {large[0]}, too large for int64")
    return values.astype(np.int64)


def _numbers(values: npt.NDArray[Any], where: str) -> npt.NDArray[Any]:
    """Returns float64; int64 for integers that float64 would round."""
    if values.dtype.kind in "iu" and np.any((values > 2**53) | (values < -(2**53))):
        return _whole(values, where)
    return values.astype(np.float64)


class _File:
    def __init__(self, file: Any, path: str, dataset: Optional[str]) -> None:
        self.file, self.where = file, path
        name = (dataset or "").strip("/")
        if not name or (name in file and not hasattr(file[name], "shape")):
            name = _points(file, name + "/" if name else "", path)
        if name not in file:
            raise ValueError(f"{path}: no dataset {name!r}")
        self.name, self.set = name, file[name]
        shape = self.set.shape
        if self.set.dtype.kind != "f" or len(shape) not in (2, 3) or shape[-1] not in (2, 3):
            raise ValueError(f"{path}: dataset {name!r} has shape {shape} of {self.set.dtype}, expected (N, 3) or (N, 2) of floats")
        self.count = shape[0] if len(shape) == 3 else None
        self.group = _stem(name).rpartition("/")[0]
        self.particles = self.group if _stem(name).endswith("/position") else None
        header = file["Header"].attrs if "Header" in file else {}
        if np.ravel(header.get("NumFilesPerSnapshot", 1))[0] > 1:
            raise ValueError(f"{path}: one of several files of a snapshot, which need a clvotess built with HDF5")

    def step(self, element: str, row: int) -> Optional[int]:
        """Returns the step of a row of an element of H5MD. A scalar is the distance of steps."""
        steps = self.file.get(element + "/step")
        if steps is None or steps.dtype.kind not in "iu" or steps.ndim > 1 or (steps.ndim == 1 and row >= len(steps)):
            return None
        return int(steps[row]) if steps.ndim else int(steps[()]) * row + int(np.ravel(steps.attrs.get("offset", 0))[0])

    def element(self, group: str, name: str, frame: int) -> npt.NDArray[Any]:
        """Returns the value of an element at a frame; empty without it."""
        box = self.file[group]
        if f"{name}/value" not in box:
            fixed = box.attrs.get(name, box[name][()] if name in box and hasattr(box[name], "shape") else ())
            return np.ravel(fixed)
        values = box[f"{name}/value"]
        if self.count is None or values.ndim < 2:
            return np.ravel(values[()])
        row = frame
        if len(values) != self.count:
            now = self.step(f"{self.particles}/position", frame)
            steps = [self.step(f"{group}/{name}", k) for k in range(len(values))]
            early = [k for k, step in enumerate(steps) if step is not None and now is not None and step <= now]
            if not early:
                raise ValueError(f"{self.where}: dataset '{group}/{name}/value' has {len(values)} rows, expected one for each of "
                                 f"the {self.count} frames, or steps of which one is not later than frame {frame}")
            row = early[-1]
        return np.ravel(values[row])

    def _of_h5md(self, frame: int) -> Tuple[npt.NDArray[Any], Any]:
        box = f"{self.particles}/box"
        flags = self.element(box, "pbc", frame)
        if not len(flags) or not np.all(np.isfinite(flags.astype(float))):
            words = np.ravel(self.file[box].attrs.get("boundary", ()))
            flags = np.array([_text(word).lower() == "periodic" if isinstance(word, (str, bytes)) else word for word in words])
        return self.element(box, "edges", frame).astype(float), flags.astype(bool)

    def domain(self, frame: int) -> Optional[Domain]:
        own, size = self.file.attrs, self.set.shape[-1]
        if "box" in own and ("periodic" in own or np.size(own["box"]) == 2 * size):  # as votess writes it
            names = ("cell", "origin") if np.size(own.get("cell", ())) else ("box",)
            found: Any = {name: np.ravel(own[name]).astype(float) for name in names}
            walls = np.array(self.file["walls"], float) if "walls" in self.file else ()
            return domain_of({**found, "periodic": tuple(bool(axis) for axis in np.ravel(own.get("periodic", [False] * size))), "walls": walls})
        periodic: Any = [False] * size
        edges: Any = ()
        if self.particles and f"{self.particles}/box" in self.file:
            edges, flags = self._of_h5md(frame)
            periodic = flags if len(flags) == size else periodic
        elif "cell_lengths" in self.file and "cell_angles" in self.file:
            from .atoms import _edges_of_lengths_and_angles

            rows = [np.atleast_2d(self.file[name]) for name in ("cell_lengths", "cell_angles")]
            edges = np.ravel(_edges_of_lengths_and_angles([x for row in rows for x in row[min(frame, len(row) - 1)]]))
            periodic = [True] * 3
        elif "Header" in self.file:
            sides = np.ravel(self.file["Header"].attrs.get("BoxSize", 0)).astype(float)
            edges = np.broadcast_to(sides, 3) if len(sides) in (1, 3) and np.all((sides > 0) & np.isfinite(sides)) else ()
            flag = self.file["RuntimePars"].attrs.get("PeriodicBoundariesOn", 0) if "RuntimePars" in self.file else 0
            periodic = [bool(np.ravel(flag)[0])] * 3
        axes = tuple(bool(axis) for axis in periodic)
        if len(edges) == size and np.all(edges):
            return domain_of({"box": np.concatenate((np.zeros(size), edges)), "periodic": axes})
        if len(edges) == size:  # no end along an edge that is 0
            edges = np.diag(edges)
        if np.size(edges) == size * size and np.any(edges):
            return domain_of({"cell": np.reshape(edges, (size, size)), "periodic": axes})
        return domain_of({"periodic": axes}) if any(axes) else None

    def column(self, path: str, frame: int) -> npt.NDArray[Any]:
        values: Any = self.file[path]
        framed = self.count is not None and values.ndim >= 2 and values.shape[:2] == self.set.shape[:2]
        array: npt.NDArray[Any] = values[frame] if framed else values[()]
        return array

    def find(self, name: str) -> Optional[str]:
        """Returns the path of a column, in the group of the points or at the root."""
        for path in (f"{self.group}/{name}".strip("/"), name.strip("/")):
            for own in (path + "/value", path):
                if own in self.file and hasattr(self.file[own], "shape"):
                    return own
        return None

    def names(self, count: int, frame: int) -> List[str]:
        """Returns the names of all columns of numbers beside the points."""
        group = self.file[self.group] if self.group else self.file
        names = []
        for name in group:
            path = self.find(name) if name not in ("ParticleIDs", "ids") else None
            if path and path != self.name and self.file[path].dtype.kind in "fiu":
                values = self.column(path, frame)
                if values.ndim in (1, 2) and len(values) == count:
                    names.append(name)
        return names

    def units(self) -> Dict[str, Any]:
        units = {}
        for group in ("Header", "Units"):
            for name, value in self.file[group].attrs.items() if group in self.file else ():
                scales = name.startswith("Unit") or name in ("HubbleParam", "Time", "Redshift")
                if scales and np.size(value) == 1 and np.asarray(value).dtype.kind in "fiu":
                    units[name] = float(np.ravel(value)[0])
        return units

    def read(self, frame: int, columns: Sequence[str]) -> Dict[str, Any]:
        """Returns the arguments of a Frame."""
        points = np.array(self.column(self.name, frame), np.float64)
        found: Dict[str, npt.NDArray[Any]] = {}
        for name in self.names(len(points), frame) if list(columns) == ["all"] else columns:
            path = self.find(name)
            if path is None:
                raise ValueError(f"{self.where}: no dataset {name!r}, neither in the group of the points nor at the root")
            values, where = np.array(self.column(path, frame)), f"{self.where}: dataset {path!r}"
            if values.ndim not in (1, 2) or len(values) != len(points) or values.dtype.kind not in "fiu":
                raise ValueError(f"{where} has shape {values.shape} of {values.dtype}, expected numbers for each of the {len(points)} points")
            found[name] = _numbers(values, where)
        ids, kept = None, np.full(len(points), True)
        for name in _IDS:
            path = f"{self.group}/{name}".strip("/")
            if path not in self.file or not hasattr(self.file[path], "shape") or path == self.name:
                continue
            values = self.column(path, frame)
            if values.shape != (len(points),) or values.dtype.kind not in "iu":
                continue
            filled = self.particles is not None and self.file[path].id.get_create_plist().fill_value_defined() == 2  # by the user
            absent = self.file[path].fillvalue if filled else None
            ids = _whole(values, f"{self.where}: dataset {path!r}", absent)
            if absent is not None:
                kept &= values != absent
            break
        if self.particles is not None:
            real = np.flatnonzero(~np.all(np.isnan(points), axis=1))
            if len(real):
                kept[real[-1] + 1 :] = False
        step = self.step(f"{self.particles}/position", frame) if self.particles and self.count is not None else None
        return {
            "number": frame, "points": points[kept], "domain": self.domain(frame), "timestep": None if step is None else float(step),
            "ids": None if ids is None else ids[kept], "columns": {name: values[kept] for name, values in found.items()}, "units": self.units(),
        }  # fmt: skip


def _text(word: Any) -> str:
    return word.decode("utf-8", "replace") if isinstance(word, bytes) else str(word)


def _range(frames: str, count: int) -> range:
    """Returns the numbers of the frames."""
    parts = re.fullmatch(r"(\d*):(\d*)(?::(\d*))?", {"all": ":", "last": f"{count - 1}:"}.get(frames, frames))
    if parts is None or parts[3] == "0":
        raise ValueError(f"frames must be all, last or a:b:c, frames a to b - 1 in steps of c, counted from 0, not {frames!r}")
    return range(int(parts[1] or 0), min(int(parts[2] or count), count), int(parts[3] or 1))


def frames_of(path: str, frames: str, dataset: Optional[str], columns: Sequence[str]) -> Iterator[Dict[str, Any]]:
    """Returns the arguments of each Frame of a file. Raises ImportError without h5py."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("read_frames() of HDF5 needs h5py, or a clvotess that was built with HDF5") from error

    with h5py.File(path, "r") as handle:
        file = _File(handle, path, dataset)
        numbers = _range(frames, 1 if file.count is None else file.count)
        if not len(numbers):
            raise ValueError(f"{path}: frame {frames} is missing, the file has {file.count or 1}, counted from 0")
        for number in numbers:
            yield file.read(number, columns)
