"""A file that is written whole or not at all, also after a loss of power."""

from __future__ import annotations

import contextlib
import errno
import os
from typing import Callable, Iterator, Optional, Tuple, TypeVar

_Result = TypeVar("_Result")
_UNKNOWN = (errno.EINVAL, errno.EROFS, errno.ENOTSUP, errno.ENOSYS)  # of file systems that know no fsync


@contextlib.contextmanager
def whole_file(path: str) -> Iterator[str]:
    """Yields the path of a temporary file, which takes the place of ``path`` when no error is raised.

    The file has no name until then, so that a process that is killed leaves nothing. It leaves a file
    ``.pyvotess-*.tmp`` in two cases: where the system or the file system has no unnamed files (``O_TMPFILE``), and
    between the two calls that replace an old file. File and folder are brought to the disk. A link stays a link: its
    target is replaced, whose permissions the new file keeps.
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
    """Of an open file, also one that has no name; valid in this process."""
    return f"/proc/self/fd/{descriptor}"


def _new_file(folder: str) -> Tuple[Optional[str], int]:
    """An open file, and its name if it has one."""
    # Not by tempfile, whose files nobody else may read.
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
    """Names an unnamed file ``target``. Where that name is taken, returns another that the file got instead."""
    folder = os.path.dirname(target)
    directory = os.open(folder, os.O_PATH | os.O_DIRECTORY)
    try:

        def link(name: str) -> None:  # only with dir_fd os.link follows the link in /proc
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
    except PermissionError:  # a folder that may be written but not read cannot be synced
        return
    try:
        _sync(directory)
    finally:
        os.close(directory)
