"""The arrays of a result as .npz and .h5, with the names, types and shapes of clvotess."""

from __future__ import annotations

import errno
import os
import shutil
import zipfile
from typing import TYPE_CHECKING, Any, Dict

import numpy as np

from .._arrays import TABLE
from .optional import imported

if TYPE_CHECKING:
    import numpy.typing as npt

    from .._state import SeedCells

    Arrays = Dict[str, npt.NDArray[Any]]

#: Reserved names in both formats, which the caller's columns must not have.
NAMES = frozenset(TABLE).difference(("weights",)).union(
    "box periodic cell origin walls version domain_from periodic_from".split()
)


def _result_arrays(t: SeedCells) -> Arrays:
    held = t._data.arrays
    ids = {"ids": t.ids.astype(np.int64)} if t.ids is not None and len(t.ids) > 0 else {}
    return {**ids, **{name: held[name] for name in TABLE if name in held and name not in ("ids", "weights")}}


def _domain_arrays(t: SeedCells) -> Arrays:
    arrays: Arrays = {"box": t.box, "periodic": np.array(t.periodic, np.uint8)}
    if t.cell is not None and t.origin is not None:
        arrays.update(cell=t.cell, origin=t.origin)
    if len(t.walls):
        arrays["walls"] = t.walls
    return arrays


def _texts(t: SeedCells) -> Dict[str, str]:
    from .._library import VERSION

    return {
        "domain_from": "option" if t._given_domain._has_ends else "default",
        "periodic_from": "option" if any(t.periodic) else "default",
        "version": VERSION,
    }


def write_npz(path: str, t: SeedCells, columns: Arrays) -> None:
    """Writes an archive without compression. It does not use numpy.savez, whose argument is called "file" too."""
    arrays = {**_result_arrays(t), **columns, **_domain_arrays(t)}
    arrays.update({name: np.array(text) for name, text in _texts(t).items()})
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
        for name, array in arrays.items():
            with archive.open(name + ".npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def write_h5(path: str, t: SeedCells, columns: Arrays, name: str) -> None:
    """Writes datasets at the root. The domain except the walls, and texts, are attributes of the root.

    ``name``: the file's, for errors. Raises OSError when the file cannot be written.
    """
    bytes_needed = sum(array.nbytes for array in (*_result_arrays(t).values(), *columns.values()))
    # HDF5 may crash when the process ends after a write that failed: better not to begin.
    if shutil.disk_usage(os.path.dirname(os.path.realpath(name))).free < bytes_needed:
        raise OSError(errno.ENOSPC, f"{os.strerror(errno.ENOSPC)}: the file takes {bytes_needed} bytes", name)
    try:
        _write_h5(path, t, columns)
    except RuntimeError as error:  # from h5py
        raise OSError(errno.EIO, f"HDF5 failed: {error}", name) from error


def _write_h5(path: str, t: SeedCells, columns: Arrays) -> None:
    h5py = imported("h5py", "writing .h5")
    # The default driver cannot open a file without a name.
    with h5py.File(path, "w", driver="stdio") as file:
        for name, array in {**_result_arrays(t), **columns}.items():
            file.create_dataset(name, data=array)
        for name, array in _domain_arrays(t).items():
            if name == "walls":  # an attribute holds at most 64 kB
                file.create_dataset(name, data=array)
            else:
                file.attrs[name] = array
        for name, text in _texts(t).items():
            file.attrs[name] = np.bytes_(text)
