"""What ``progress=True`` shows: a bar of tqdm where it is installed, else a line on stderr."""

from __future__ import annotations

import contextlib
import importlib
import sys
from typing import Any, Callable, Iterator, Optional, Union

#: Called some ten times a second with the fraction done, 0 to 1. Return False to stop the run; None goes on.
Progress = Callable[[float], Optional[bool]]


class _Line:
    """Writes the percentage over the last one, only when it has changed."""

    def __init__(self) -> None:
        self._shown = -1

    def show(self, fraction: float) -> None:
        percent = int(100 * fraction)
        if percent != self._shown:
            self._shown = percent
            print(f"\rvotess: {percent} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        if self._shown >= 0:
            print(file=sys.stderr, flush=True)


class _Bar:
    def __init__(self, tqdm: Any) -> None:
        self._bar = tqdm(total=100, desc="votess", unit="%", bar_format="{desc}: {percentage:3.0f} %|{bar}| {elapsed}")

    def show(self, fraction: float) -> None:
        self._bar.update(100 * fraction - self._bar.n)

    def close(self) -> None:
        self._bar.close()


@contextlib.contextmanager
def showing(progress: Union[None, bool, Progress]) -> Iterator[Optional[Progress]]:
    """Yields what the run is to call. TypeError when ``progress`` is neither a bool nor callable."""
    if progress is None or progress is False:
        yield None
        return
    if progress is not True:
        if not callable(progress):
            raise TypeError(f"progress must be callable, True or False, not {type(progress).__name__}")
        yield progress
        return
    display: Union[_Line, _Bar]
    try:
        tqdm = importlib.import_module("tqdm.auto").tqdm
    except ImportError:
        display = _Line()
    else:
        display = _Bar(tqdm)

    def call(fraction: float) -> None:
        display.show(fraction)

    try:
        yield call
        display.show(1.0)
    finally:
        display.close()
