"""Pauses the garbage collector, which would scan growing lists of lists again and again."""

from __future__ import annotations

import contextlib
import gc
from typing import Iterator


@contextlib.contextmanager
def garbage_collector_paused() -> Iterator[None]:
    """The block must not create reference cycles."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
