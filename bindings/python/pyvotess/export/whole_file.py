"""A file that is written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
from typing import Iterator


@contextlib.contextmanager
def whole_file(path: str) -> Iterator[str]:
    """Yields the name of a temporary file in the folder of ``path``, which takes its place when no error is raised.

    A link stays a link: its target is replaced, whose permissions the new file keeps.
    """
    target = os.path.realpath(path)
    folder = os.path.dirname(target)
    if not os.path.isdir(folder):
        raise FileNotFoundError(errno.ENOENT, "there is no folder for", path)
    if os.path.lexists(target) and not os.path.isfile(target):
        raise ValueError(f"cannot write {path!r}: it is no regular file")
    temporary = _new_file(folder)
    try:
        yield temporary
        with contextlib.suppress(OSError):
            os.chmod(temporary, os.stat(target).st_mode & 0o7777)
        os.replace(temporary, target)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise


def _new_file(folder: str) -> str:
    # Not by tempfile, whose files nobody else may read.
    for attempt in range(1000):
        name = os.path.join(folder, f".pyvotess-{os.getpid()}-{attempt}.tmp")
        with contextlib.suppress(FileExistsError):
            os.close(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
            return name
    raise FileExistsError(errno.EEXIST, "too many temporary files in", folder)
