"""A file that is written whole or not at all, also after a power failure."""

from __future__ import annotations

import contextlib
import errno
import os
from typing import Callable, Iterator, Optional, Tuple, TypeVar

_Result = TypeVar("_Result")
_UNKNOWN = (errno.EINVAL, errno.EROFS, errno.ENOTSUP, errno.ENOSYS)  # from file systems without fsync


@contextlib.contextmanager
def whole_file(path: str) -> Iterator[str]:
    """Yields the path of a temporary file, which replaces ``path`` if the block raises no error.

    The file has no name until then. A killed process leaves a file ``.pyvotess-*.tmp`` in two cases only: where unnamed
    files (``O_TMPFILE``) are not supported, and between the two calls that replace an old file. File and folder are
    synced. If ``path`` is a link, its target is replaced. A replaced file keeps its permissions.

    Raises FileNotFoundError without the folder, ValueError if ``path`` is not a regular file, OSError if writing fails.
    """
    target = os.path.realpath(path)
    folder = os.path.dirname(target)
    if not os.path.isdir(folder):
        raise FileNotFoundError(errno.ENOENT, "there is no folder for", path)
    if os.path.lexists(target) and not os.path.isfile(target):
        raise ValueError(f"cannot write {path!r}: it is not a regular file")
    name, descriptor = _new_file(folder)
    try:
        yield name or _path_of(descriptor)
        with contextlib.suppress(OSError):
            os.fchmod(descriptor, os.stat(target).st_mode & 0o7777)
        _sync(descriptor)
        if name is None:
            name = _link(descriptor, target)
        if name is not None:
            os.replace(name, target)
            name = None
        _sync_folder(folder)
    except BaseException:
        if name is not None:
            with contextlib.suppress(OSError):
                os.unlink(name)
        raise
    finally:
        os.close(descriptor)


def _path_of(descriptor: int) -> str:
    """Returns a path of an open file, which may have no name. It is valid in this process."""
    return f"/proc/self/fd/{descriptor}"


def _new_file(folder: str) -> Tuple[Optional[str], int]:
    """Returns the name of a new file, or None, and its descriptor."""
    # tempfile would make a file that only the owner can read.
    if hasattr(os, "O_TMPFILE"):
        with contextlib.suppress(OSError):
            descriptor = os.open(folder, os.O_TMPFILE | os.O_WRONLY, 0o666)
            if os.path.exists(_path_of(descriptor)):
                return None, descriptor
            os.close(descriptor)
    return _with_free_name(folder, lambda name: os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))


def _with_free_name(folder: str, make: Callable[[str], _Result]) -> Tuple[str, _Result]:
    for attempt in range(1000):
        name = os.path.join(folder, f".pyvotess-{os.getpid()}-{attempt}.tmp")
        with contextlib.suppress(FileExistsError):
            return name, make(name)
    raise FileExistsError(errno.EEXIST, "too many temporary files in", folder)


def _link(descriptor: int, target: str) -> Optional[str]:
    """Gives an unnamed file the name ``target``. If it is taken, returns another name that the file got."""
    folder = os.path.dirname(target)
    directory = os.open(folder, os.O_PATH | os.O_DIRECTORY)
    try:

        def link(name: str) -> None:  # os.link follows the link in /proc only with dir_fd
            os.link(_path_of(descriptor), name, src_dir_fd=directory)

        try:
            link(target)
        except FileExistsError:
            return _with_free_name(folder, link)[0]
        return None
    finally:
        os.close(directory)


def _sync(descriptor: int) -> None:
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in _UNKNOWN:
            raise


def _sync_folder(folder: str) -> None:
    try:
        directory = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except PermissionError:  # a folder without read permission cannot be synced
        return
    try:
        _sync(directory)
    finally:
        os.close(directory)
