"""Calls of the library: errors, handles, arrays in its memory, callbacks, and the display of progress."""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import re
import sys
import threading
from typing import TYPE_CHECKING, Any, Callable, Dict, Generator, Iterator, List, Optional, Tuple, Type, TypeVar, Union

import numpy as np

from . import _c_api
from ._c_api import ErrorCode
from ._library import lib

if TYPE_CHECKING:
    from types import TracebackType

    import numpy.typing as npt


#: Called about ten times a second with the fraction done, 0 to 1. Returns False to stop the run; None continues.
Progress = Callable[[float], Optional[bool]]


class VotessError(RuntimeError):
    """A run failed, and the input is not the cause. ``code`` is the reason, an :class:`ErrorCode`."""

    def __init__(self, message: str, code: ErrorCode) -> None:
        super().__init__(message, code)
        self.code = code

    def __str__(self) -> str:
        return str(self.args[0])


# An option in a message of the library, with its value: options.outside = drop. Arguments of other names follow.
_OPTION = re.compile(r"\b(?:(?:[a-z_]+_)?options|stream(?=\.memory\b))\.(want\.)?(\w+(?:\.\w+)?)( = [^\s:,)]+)?")
_ARGUMENTS = {"planar": "points= of shape (N, 2)", "cell.periodic": "periodic=", "cell.origin": "origin=",
              "mesh.merge": 'mesh_repair="merge"', "mesh.tolerance": "mesh_tolerance=", "skip_open": "open='skip'"}  # fmt: skip


def _argument(option: re.Match[str]) -> str:
    want, name, value = option.groups()
    if want:
        return f'want="{name}"'
    argument = _ARGUMENTS.get(name, name + "=")
    shown = re.sub("=.*", "", argument) if "." in name else name
    if value is None:
        is_subject = option.string[option.end() :].startswith((":", " is ", " has ", " hold "))
        return shown if is_subject else argument
    return shown + "=" + (value[3:] if re.search(r"\d", value) else f'"{value[3:]}"')


# A row at the begin of a message, also after the name of a function: radius 0 = -5.
_ROW = re.compile(r"^(\w+\(\): )?(?:\w+: )?(point|radius|weight|the target volume of point) (\d+)(?=:| = | is )")
_ARRAYS = {"point": "points", "radius": "radii", "weight": "weights", "the target volume of point": "volumes"}


def last_error() -> str:
    """Returns the message of the library, with options and rows as arguments of Python."""
    message = _OPTION.sub(_argument, lib.votess_last_error().decode("utf-8", "replace"))
    return _ROW.sub(lambda row: f"{row[1] or ''}{_ARRAYS[row[2]]}[{row[3]}]", message)


def raise_on_failure(status: int) -> None:
    if status == _c_api.OK:
        return
    message = last_error()
    if status == ErrorCode.INVALID_ARGUMENT:
        raise ValueError(message)
    if status == ErrorCode.OUT_OF_MEMORY:
        raise MemoryError(message)
    raise VotessError(message, ErrorCode(status))


def view_of(read: Any, owner: Any, name: str, *part: int, writable: bool = False) -> npt.NDArray[Any]:
    """Returns a view of an array of ``owner``, see :meth:`Handle.array`. ``read``: ``votess_<kind>_array``."""
    found = _c_api.Array()
    raise_on_failure(read(owner, *part, name.encode(), found))
    dtype = np.dtype(f"{found.kind.decode()}{found.bytes}")
    shape = (found.length,) if found.components == 1 else (found.length, found.components)
    if found.data:
        return np.asarray(_Memory(owner, found.data, shape, dtype, writable))
    none = np.empty(shape, dtype)
    none.flags.writeable = writable
    return none


class Handle:
    """Owns one object of the library, whose functions have names as ``votess_<kind>_free``."""

    def __init__(self, kind: str, library: ctypes.CDLL = lib) -> None:
        self.pointer: Any = ctypes.c_void_p()
        self._kind, self._library = kind, library
        self._free = getattr(library, f"votess_{kind}_free")  # modules may be gone when the interpreter ends

    @classmethod
    def made(cls, kind: str, function: Any, *arguments: Any) -> Handle:
        """Returns what ``function(*arguments, out)`` makes. Ctrl-C stops it."""
        handle = cls(kind)
        raise_on_failure(watched(function, *arguments, handle))
        return handle

    @property
    def _as_parameter_(self) -> Any:
        """What ctypes passes."""
        return self.pointer

    def arrays(self, *names: str) -> Dict[str, npt.NDArray[Any]]:
        return {name: self.array(name) for name in names}

    def array(self, name: str, *part: int, writable: bool = False) -> npt.NDArray[Any]:
        """Returns a view of an array, without a copy: (length,), or (length, components) if it has several.

        ``part``: arguments before the name, for kinds with several arrays of a name. ``writable``: for an object of which
        the library reads nothing more.
        """
        return view_of(getattr(self._library, f"votess_{self._kind}_array"), self, name, *part, writable=writable)

    def free(self) -> None:
        # Cleared first: a signal handler may raise right after the call, and free() may be called again. None is NULL for
        # ctypes, and no module is needed: all of them may be empty when the interpreter ends.
        pointer, self.pointer = self.pointer, None
        if pointer:
            self._free(pointer)

    def __del__(self) -> None:
        self.free()

    def __reduce__(self) -> Any:
        raise TypeError("an object of the library cannot be pickled or deep-copied")


class WithHandle:
    """An object with arrays, and the library's object for further computations. Pickles hold the arrays alone."""

    _handle: Optional[Handle]

    def __getstate__(self) -> Dict[str, Any]:
        return dict(self.__dict__, _handle=None)

    def __copy__(self) -> Any:
        """Returns a copy that shares everything."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        return other

    def _pointer(self, source: str) -> Any:
        """Returns the library's object. ``source``: what made it, for the error."""
        if self._handle is None:
            raise ValueError(f"a pickle or deep copy holds no object of the library: use what {source} returned")
        return self._handle.pointer


class _Memory:
    """Wraps an array of the library for NumPy. It becomes the base of the ndarray and keeps the owner alive."""

    def __init__(
        self, owner: Handle, address: int, shape: Tuple[int, ...], dtype: np.dtype[Any], writable: bool
    ) -> None:
        self._owner = owner
        self.__array_interface__ = {
            "version": 3,
            "shape": shape,
            "typestr": dtype.str,
            "data": (address, not writable),
        }


class Callbacks:
    """Callbacks for one call of the library. The block raises their first error.

    >>> with Callbacks() as callbacks:
    ...     status = lib.function(..., callbacks.progress(progress))
    >>> raise_on_failure(status)

    This includes errors of signal handlers, which Python runs in the main thread between its own instructions, so in a
    callback while the library runs. Without this class ctypes would print the error and return an arbitrary number.
    """

    def __init__(self) -> None:
        self._raised: Optional[BaseException] = None
        self._kept: List[Any] = []
        self._gets_signals = threading.current_thread() is threading.main_thread()

    def __enter__(self) -> Callbacks:
        return self

    def __exit__(
        self, kind: Optional[Type[BaseException]], error: Optional[BaseException], traceback: Optional[TracebackType]
    ) -> None:
        raised, self._raised = self._raised, None
        self._kept.clear()
        if raised is not None and error is None:
            try:
                raise raised
            finally:
                del raised  # the traceback holds this frame

    def guarded(self, prototype: Any, work: Callable[[Any], int], stop: int) -> Any:
        """Returns a callback that calls ``work`` with the first argument. After an error it returns ``stop``."""
        answers = self._answers(work, stop)
        next(answers)
        callback = prototype(answers.send)
        self._kept.append(callback)
        return callback

    def _answers(self, work: Callable[[Any], int], stop: int) -> Generator[int, Any, None]:
        # A generator, because a signal handler may run when a function is entered, before its try.
        answer = stop
        try:
            while True:
                argument = yield answer
                answer = stop if self._raised is not None else work(argument)
        except GeneratorExit:
            return
        except BaseException as error:
            if self._raised is None:
                self._raised = error
        while True:
            yield stop

    def progress(self, progress: Optional[Progress]) -> Any:
        """Returns the progress callback for the library: it calls ``progress`` and lets signal handlers run.

        It is NULL when neither is needed.
        """
        if progress is None and not self._gets_signals:
            return _c_api.ProgressCallback()

        def call(fraction: float) -> int:
            answer = None if progress is None else progress(fraction)
            return 1 if answer is None or answer else 0

        return self.guarded(_c_api.ProgressCallback, call, 0)


def run(
    function: Any, *arguments: Any, options: _c_api.Struct, progress: Union[None, bool, Progress] = None, returned: int = _c_api.OK
) -> int:
    """Calls ``function(*arguments)``, which calls the progress of ``options``, one of the arguments. Raises for a failure.

    ``returned``: a status that is returned instead.
    """
    with showing(progress) as show:
        with Callbacks() as callbacks:
            options.progress = callbacks.progress(show)
            status = int(function(*arguments))
        if status != returned:
            raise_on_failure(status)
    return status


def watched(function: Any, *arguments: Any) -> int:
    """Returns the status of a function of the library that takes no callback. Ctrl-C stops it."""
    with Callbacks() as callbacks:
        lib.votess_set_progress(callbacks.progress(None), None)
        try:
            return int(function(*arguments))
        finally:
            lib.votess_set_progress(_c_api.ProgressCallback(), None)


_Owner = TypeVar("_Owner", bound="OneCallAtATime")


class OneCallAtATime:
    """An object that serves one call at a time. A context manager."""

    _kind: str  #: for errors
    _lock: threading.Lock

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        """Lets one call at a time into the block."""
        if not self._lock.acquire(blocking=False):
            raise VotessError(
                f"this {self._kind} is in use by another call, or was during fork(): use one for each thread",
                ErrorCode.INVALID_USE,
            )
        try:
            yield
        finally:
            self._lock.release()

    def close(self) -> None:
        raise NotImplementedError

    def __enter__(self: _Owner) -> _Owner:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


# Display of progress=True: a bar of tqdm if it is installed, else a line on stderr.
class _Line:
    """Overwrites the percentage when it changes."""

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
    """Yields the progress function of a run, or None. Raises TypeError unless ``progress`` is a bool or callable."""
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
