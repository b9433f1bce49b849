"""Lists of lists in bulk without the garbage collector, which would look through them again and again."""

from __future__ import annotations

import contextlib
import gc
from typing import Iterator


@contextlib.contextmanager
def garbage_collector_paused() -> Iterator[None]:
    """What is made meanwhile must hold no cycles."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
