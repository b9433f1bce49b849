"""CUDA's driver by ctypes: memory and a semaphore that Vulkan exports, and arrays in that memory.

A dozen functions of the driver's library are enough, so no package of CUDA is needed. It is loaded at the first use.
"""

from __future__ import annotations

import contextlib
import ctypes
import sys
from ctypes import POINTER, c_char_p, c_int, c_int32, c_int64, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p
from typing import Any, Dict, Iterator, Optional, Tuple

import numpy as np

from ._arguments import as_count, shown
from ._c_api import ErrorCode
from ._call import VotessError

LIBRARY = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
_OLDEST = 11020  # timeline semaphores

_OPAQUE_FD, _TIMELINE_FD, _DEDICATED = 1, 9, 1
_DEVICE_ORDINAL = 9  # of a pointer
_OUT_OF_MEMORY = 2


class _Handle(ctypes.Union):
    _fields_ = [("descriptor", c_int), ("win32", c_void_p * 2)]


class _MemoryHandle(ctypes.Structure):
    _fields_ = [("type", c_int), ("handle", _Handle), ("size", c_uint64), ("flags", c_uint32), ("reserved", c_uint32 * 16)]


class _MemoryPart(ctypes.Structure):
    _fields_ = [("offset", c_uint64), ("size", c_uint64), ("flags", c_uint32), ("reserved", c_uint32 * 16)]


class _SemaphoreHandle(ctypes.Structure):
    _fields_ = [("type", c_int), ("handle", _Handle), ("flags", c_uint32), ("reserved", c_uint32 * 16)]


class _SemaphoreValue(ctypes.Structure):
    """For signals and waits."""

    _fields_ = [("value", c_uint64), ("others", c_uint32 * 16), ("flags", c_uint32), ("reserved", c_uint32 * 16)]


_FUNCTIONS: Dict[str, Tuple[Any, ...]] = {
    "cuInit": (c_uint32,),
    "cuDriverGetVersion": (POINTER(c_int),),
    "cuGetErrorName": (c_int, POINTER(c_char_p)),
    "cuDeviceGetCount": (POINTER(c_int),),
    "cuDeviceGet": (POINTER(c_int), c_int),
    "cuDeviceGetUuid": (c_void_p, c_int),
    "cuDevicePrimaryCtxRetain": (POINTER(c_void_p), c_int),
    "cuDevicePrimaryCtxRelease_v2": (c_int,),
    "cuCtxPushCurrent_v2": (c_void_p,),
    "cuCtxPopCurrent_v2": (POINTER(c_void_p),),
    "cuCtxSynchronize": (),
    "cuImportExternalMemory": (POINTER(c_void_p), POINTER(_MemoryHandle)),
    "cuExternalMemoryGetMappedBuffer": (POINTER(c_uint64), c_void_p, POINTER(_MemoryPart)),
    "cuDestroyExternalMemory": (c_void_p,),
    "cuMemFree_v2": (c_uint64,),
    "cuImportExternalSemaphore": (POINTER(c_void_p), POINTER(_SemaphoreHandle)),
    "cuDestroyExternalSemaphore": (c_void_p,),
    "cuSignalExternalSemaphoresAsync": (POINTER(c_void_p), POINTER(_SemaphoreValue), c_uint32, c_void_p),
    "cuWaitExternalSemaphoresAsync": (POINTER(c_void_p), POINTER(_SemaphoreValue), c_uint32, c_void_p),
    "cuMemcpyDtoDAsync_v2": (c_uint64, c_uint64, c_size_t, c_void_p),
    "cuPointerGetAttribute": (c_void_p, c_int, c_uint64),
    "cuStreamIsCapturing": (c_void_p, POINTER(c_int)),
    "cuStreamSynchronize": (c_void_p,),
}


def _unsupported(message: str) -> VotessError:
    return VotessError(message + "; device='auto' takes arrays in the host's memory", ErrorCode.UNSUPPORTED)


class Driver:
    """The functions of the driver. Each raises VotessError with the driver's word for the failure."""

    def __init__(self) -> None:
        try:
            self._library = ctypes.CDLL(LIBRARY)
        except OSError as error:
            raise _unsupported(f"device='cuda' needs NVIDIA's driver, and {LIBRARY} cannot be loaded: {error}") from None
        for name, types in _FUNCTIONS.items():
            function = getattr(self._library, name, None)
            if function is None:
                raise _unsupported(f"device='cuda' needs a driver of CUDA 11.2 or newer: {LIBRARY} lacks {name}")
            function.restype, function.argtypes = c_int, types
        self("cuInit", 0)
        version = c_int()
        self("cuDriverGetVersion", ctypes.byref(version))
        if version.value < _OLDEST:
            found = f"{version.value // 1000}.{version.value % 1000 // 10}"
            raise _unsupported(f"device='cuda' needs a driver of CUDA 11.2 or newer, this one has {found}")

    def __call__(self, name: str, *arguments: Any) -> None:
        status = getattr(self._library, name)(*arguments)
        if status == 0:
            return
        text = c_char_p()
        self._library.cuGetErrorName(status, ctypes.byref(text))
        word = text.value.decode() if text.value else str(status)
        if status == _OUT_OF_MEMORY:
            raise MemoryError(f"{name} of CUDA: {word}: the GPU is out of memory, lower max_points")
        raise VotessError(f"{name} of CUDA: {word}", ErrorCode.UNSUPPORTED)

    def uuid(self, ordinal: int) -> bytes:
        """Returns the UUID of a device."""
        count, device, uuid = c_int(), c_int(), ctypes.create_string_buffer(16)
        self("cuDeviceGetCount", ctypes.byref(count))
        if ordinal >= count.value:
            raise _unsupported(f"device is 'cuda:{ordinal}', but CUDA has {count.value} devices, from 0 on")
        self("cuDeviceGet", ctypes.byref(device), ordinal)
        self("cuDeviceGetUuid", uuid, device)
        return uuid.raw


def semaphore_of(export: Any, device: str) -> int:
    """Returns the descriptor of the exported semaphore."""
    descriptor: int = export.semaphore_descriptor
    if descriptor < 0:
        raise _unsupported(f"{device} cannot export a semaphore (VK_KHR_external_semaphore_fd)")
    return descriptor


class Importer:
    """Exported memory and an exported semaphore in a device's primary context."""

    def __init__(self, driver: Driver, ordinal: int, export: Any, device: str, memory_owner: Any) -> None:
        self._driver, self.ordinal, self._memory_owner = driver, ordinal, memory_owner
        self._memory, self._semaphore, self._base = c_void_p(), c_void_p(), c_uint64()
        self._device, self._context = c_int(), c_void_p()
        descriptor = semaphore_of(export, device)
        driver("cuDeviceGet", ctypes.byref(self._device), ordinal)
        driver("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), self._device)
        try:
            with self._current():
                memory = _MemoryHandle(type=_OPAQUE_FD, size=export.memory_bytes, flags=_DEDICATED)
                memory.handle.descriptor = export.memory_descriptor
                driver("cuImportExternalMemory", ctypes.byref(self._memory), ctypes.byref(memory))
                part = _MemoryPart(size=export.memory_bytes)
                driver("cuExternalMemoryGetMappedBuffer", ctypes.byref(self._base), self._memory, ctypes.byref(part))
                semaphore = _SemaphoreHandle(type=_TIMELINE_FD)
                semaphore.handle.descriptor = descriptor
                driver("cuImportExternalSemaphore", ctypes.byref(self._semaphore), ctypes.byref(semaphore))
        except BaseException:
            self.close()
            raise

    @contextlib.contextmanager
    def _current(self) -> Iterator[None]:
        """Makes the device's context the thread's."""
        self._driver("cuCtxPushCurrent_v2", self._context)
        try:
            yield
        finally:
            self._driver("cuCtxPopCurrent_v2", ctypes.byref(c_void_p()))

    def close(self) -> None:
        context, self._context = self._context, c_void_p()
        if not context:
            return
        self._driver("cuCtxPushCurrent_v2", context)
        self._driver("cuCtxSynchronize")  # nothing uses the memory any more
        for name, handle in (
            ("cuDestroyExternalSemaphore", self._semaphore), ("cuMemFree_v2", self._base), ("cuDestroyExternalMemory", self._memory),
        ):  # fmt: skip
            if handle.value:
                self._driver(name, handle)
        self._driver("cuCtxPopCurrent_v2", ctypes.byref(c_void_p()))
        self._driver("cuDevicePrimaryCtxRelease_v2", self._device)

    def __del__(self) -> None:
        with contextlib.suppress(Exception):  # the driver may be gone when the interpreter ends
            self.close()

    def check(self, name: str, address: int, stream: Any) -> None:
        """Refuses memory of another device, and a stream that captures."""
        ordinal, capturing = c_int(-1), c_int()
        with self._current():
            self._driver("cuPointerGetAttribute", ctypes.byref(ordinal), _DEVICE_ORDINAL, address)
            if ordinal.value != self.ordinal:
                raise ValueError(f"{name} is on device cuda:{ordinal.value}, but these Frames are of cuda:{self.ordinal}: move it there")
            self._driver("cuStreamIsCapturing", stream, ctypes.byref(capturing))
        if capturing.value:
            raise ValueError("stream is capturing a graph, which cannot hold frames: call them outside of the capture")

    def copy(self, place: int, address: int, count: int, stream: Any) -> None:
        with self._current():
            self._driver("cuMemcpyDtoDAsync_v2", self._base.value + place, address, count, stream)

    def signal(self, value: int, stream: Any) -> None:
        self._order("cuSignalExternalSemaphoresAsync", value, stream)

    def wait(self, value: int, stream: Any) -> None:
        self._order("cuWaitExternalSemaphoresAsync", value, stream)

    def _order(self, name: str, value: int, stream: Any) -> None:
        with self._current():
            self._driver(name, ctypes.byref(self._semaphore), ctypes.byref(_SemaphoreValue(value=value)), 1, stream)

    def synchronize(self, stream: Any) -> None:
        with self._current():
            self._driver("cuStreamSynchronize", stream)

    def address(self, place: int) -> int:
        return int(self._base.value + place)


class CudaInput:
    """An array on a GPU by its ``__cuda_array_interface__``."""

    def __init__(self, values: Any, name: str, shape: Tuple[Optional[int], ...], dtype: np.dtype[Any]) -> None:
        given = getattr(values, "__cuda_array_interface__", None)
        if given is None:
            raise ValueError(f"{name} is {shown(values)}: give an array with __cuda_array_interface__, such as a tensor on the GPU")
        self.shape, self.stream = tuple(given["shape"]), given.get("stream")
        self.address: int = given["data"][0] or 0
        wanted = "(" + ", ".join("N" if n is None else str(n) for n in shape) + ")"
        if len(self.shape) != len(shape) or any(n is not None and n != m for n, m in zip(shape, self.shape)):
            raise ValueError(f"{name} has shape {self.shape}: it must be {wanted}")
        if np.dtype(given["typestr"]) != dtype:
            raise ValueError(f"{name} has dtype {np.dtype(given['typestr'])}: these Frames take {dtype}, see their dtype")
        strides = given.get("strides")
        packed = tuple(int(np.prod(self.shape[k + 1 :], dtype=np.int64)) * dtype.itemsize for k in range(len(shape)))
        self.size = int(np.prod(self.shape)) * dtype.itemsize  # bytes
        if strides is not None and tuple(strides) != packed and all(self.shape):
            raise ValueError(f"{name} is not contiguous: give {name}.contiguous()")


# DLPack 0.8, https://dmlc.github.io/dlpack/latest/c_api.html


class _Tensor(ctypes.Structure):
    _fields_ = [
        ("data", c_void_p), ("device_type", c_int32), ("device_id", c_int32), ("ndim", c_int32), ("code", c_uint8), ("bits", c_uint8),
        ("lanes", c_uint16), ("shape", POINTER(c_int64)), ("strides", POINTER(c_int64)), ("byte_offset", c_uint64),
    ]  # fmt: skip


class _Managed(ctypes.Structure):
    pass


_Deleter = ctypes.CFUNCTYPE(None, POINTER(_Managed))
_Managed._fields_ = [("tensor", _Tensor), ("context", c_void_p), ("deleter", _Deleter)]
_exported: Dict[int, Any] = {}  # memory of capsules, by address
_KDL_CUDA, _CODES = 2, {"i": 0, "u": 1, "f": 2}


def _forget(managed: Any) -> None:
    _exported.pop(ctypes.addressof(managed.contents), None)


_delete = _Deleter(_forget)

_CapsuleDestructor = ctypes.PYFUNCTYPE(None, c_void_p)
_capsule_new = ctypes.PYFUNCTYPE(ctypes.py_object, c_void_p, c_char_p, _CapsuleDestructor)(("PyCapsule_New", ctypes.pythonapi))
_capsule_is = ctypes.PYFUNCTYPE(c_int, c_void_p, c_char_p)(("PyCapsule_IsValid", ctypes.pythonapi))
_capsule_get = ctypes.PYFUNCTYPE(c_void_p, c_void_p, c_char_p)(("PyCapsule_GetPointer", ctypes.pythonapi))


def _drop_unused(capsule: int) -> None:
    if _capsule_is(capsule, b"dltensor"):  # nobody took it
        _exported.pop(_capsule_get(capsule, b"dltensor"), None)


_drop = _CapsuleDestructor(_drop_unused)


class CudaArray:
    """An array in memory that votess shares with CUDA, valid until the next call of its :class:`pyvotess.gpu.Frames`.

    ``torch.as_tensor``, ``torch.from_dlpack``, ``cupy.asarray``, ``jax.numpy.from_dlpack`` and Numba take it without a copy.
    """

    def __init__(self, owner: Any, place: int, shape: Tuple[int, ...], strides: Tuple[int, ...], dtype: str, ready: Tuple[int, Any]) -> None:
        self._owner, self._ready = owner, ready
        self.shape, self.strides, self.dtype = shape, strides, np.dtype(dtype)
        self._address = owner.address(place)

    def __repr__(self) -> str:
        return f"<pyvotess array on cuda:{self._owner.ordinal} of shape {self.shape} and type {self.dtype}>"

    def __len__(self) -> int:
        return self.shape[0]

    @property
    def __cuda_array_interface__(self) -> Dict[str, Any]:
        return {
            "version": 3, "shape": self.shape, "typestr": self.dtype.str, "data": (self._address, False), "strides": self.strides,
            "stream": self._ready[1] or 1,
        }  # fmt: skip

    def __dlpack_device__(self) -> Tuple[int, int]:
        return _KDL_CUDA, self._owner.ordinal

    def __dlpack__(self, *, stream: Any = None, **options: Any) -> Any:
        value, own = self._ready
        if stream not in (None, -1) and stream != (own or 1):
            self._owner.wait(value, stream)  # the consumer's stream waits for the cells too
        managed = _Managed(deleter=_delete)
        size = len(self.shape)
        shape = (c_int64 * size)(*self.shape)
        strides = (c_int64 * size)(*(n // self.dtype.itemsize for n in self.strides))
        managed.tensor = _Tensor(
            self._address, _KDL_CUDA, self._owner.ordinal, size, _CODES[self.dtype.kind], 8 * self.dtype.itemsize, 1, shape, strides, 0
        )
        address = ctypes.addressof(managed)
        _exported[address] = managed, shape, strides, self
        return _capsule_new(address, b"dltensor", _drop)


def as_ordinal(device: str) -> int:
    """Returns the number in "cuda" or "cuda:1"."""
    number = device[len("cuda") :] or ":0"
    if number[0] != ":" or not number[1:].isdecimal():
        raise ValueError(f"device is {shown(device)}: give 'cuda' or 'cuda:' and a number")
    return as_count(int(number[1:]), "device", 16)


def as_stream(stream: Any) -> int:
    """Returns the handle of a stream: an integer, or an object of PyTorch or CuPy that has one."""
    for name in ("cuda_stream", "ptr"):
        stream = getattr(stream, name, stream)
    return as_count(stream, "stream", 64)
