"""Cells of points that move, again and again, on a Vulkan device: int32 rows and float32 sizes, for tensors.

>>> frames = vt.gpu.Frames(100_000, box=box, want="neighbors,volumes")   # doctest: +SKIP
>>> cells = frames(points)                                               # doctest: +SKIP
>>> torch.from_dlpack(cells.volumes)                                     # doctest: +SKIP
"""

from __future__ import annotations

import ctypes
import threading
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Optional, Tuple, Union

import numpy as np

from . import _c_api
from ._arguments import as_count, as_flag, as_number, counted, shown
from ._arrays import ARRAYS, WANT_BITS, WantName
from ._call import Handle, OneCallAtATime, raise_on_failure, watched
from ._domain import DomainLike, as_domain, with_short_forms
from ._input import as_float64_or_float32, as_one_each, as_points
from ._library import lib
from ._run import implied_words, new_options
from ._state import no_attribute
from .autodiff import Gradients
from .mesh import Lists

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._domain import DomainKeywords

    Int8Array = npt.NDArray[np.int8]
    Int32Array = npt.NDArray[np.int32]
    Float32Array = npt.NDArray[np.float32]

__all__ = ["CudaCells", "FrameCells", "Frames"]

_NONE = 2**64 - 1  # the place of an array that was not requested


def _as_dtype(dtype: Any) -> np.dtype[Any]:
    try:
        found: np.dtype[Any] = np.dtype(dtype)
    except (TypeError, ValueError):
        found = np.dtype(object)
    if dtype is None or found not in (np.float32, np.float64):
        raise ValueError(f"dtype is {shown(dtype)}: give float32 or float64")
    return found


class FrameCells:
    """The cells of one call of :class:`Frames`, in the order of the N points.

    Arrays are views of the library's memory, which later calls leave alone. PyTorch, JAX and others take them without a
    copy by DLPack. Arrays that are not in ``want`` are missing.
    """

    status: Int32Array  #: (N,) int32, values of :class:`CellStatus`
    indptr: Int32Array  #: (N + 1,) int32: row i of the lists is ``indices[indptr[i]:indptr[i+1]]``
    indices: Int32Array  #: (indptr[N],) int32: neighbors, ascending in each row, walls (negative) first
    shifts: Int8Array  #: (indptr[N], 3) int8 numbers of box vectors, in periodic domains
    face_areas: Float32Array  #: (indptr[N],) float32, length unit squared
    volumes: Float32Array  #: (N,) float32, with a relative error of at most 1e-5; 0 without a cell
    centroids: npt.NDArray[Any]  #: (N, 3), in the type of the points, of the cells around these as given; or NaN

    def __init__(self, frames: Frames, number: int, handle: Handle) -> None:
        self._frames, self._number = frames, number
        self._take(handle)

    def _take(self, handle: Handle) -> None:
        names = ["status", *(name for word in self._frames._wanted for name in ARRAYS[word])]
        if self._frames._periodic and "indices" in names:
            names.append("shifts")
        self.__dict__.update({name: handle.array(name, writable=True) for name in names})
        self._unresolved = int(lib.votess_frame_cells_unresolved(handle))
        self._kept = int(lib.votess_frame_cells_kept(handle))

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            if name == "shifts" and "indices" in self.__dict__:
                raise AttributeError("shifts are those of periodic domains")
            raise no_attribute(self, name, self._frames._wanted if "_frames" in self.__dict__ else None)

    def __len__(self) -> int:
        return len(self.status)

    def __repr__(self) -> str:
        arrays = [name for name in self.__dict__ if not name.startswith("_")]
        return f"<pyvotess.gpu.FrameCells of {counted(len(self), 'point')}, {self.unresolved} unresolved: {', '.join(arrays)}>"

    @property
    def unresolved(self) -> int:
        """Cells that the device left, see ``status``. They have no row."""
        return self._unresolved

    @property
    def kept_cells(self) -> int:
        """Cells of the last call that still held, in Frames with ``follow``."""
        return self._kept

    @property
    def neighbors(self) -> Lists:
        """Neighbor lists, N rows of ascending ids, walls (negative) first."""
        return Lists(self.indptr.astype(np.int64), self.indices)

    def resolve(self) -> FrameCells:
        """Makes the unresolved cells on the CPU, exactly, and returns this object. The arrays are new ones.

        Where cells are left: ValueError after another call of the same :class:`Frames`, and after its ``close()``.
        """
        if self._unresolved:
            self._take(self._frames._resolve(self._number))
        return self

    def vjp(
        self,
        volumes: Optional[npt.ArrayLike] = None,
        centroids: Optional[npt.ArrayLike] = None,
        face_areas: Optional[npt.ArrayLike] = None,
    ) -> Gradients:
        """Returns the gradient of a number by points and weights, on the device. The Frames were made with ``gradients=True``.

        Parameters
        ----------
        volumes, centroids, face_areas : derivatives of the number by these arrays, and as long. Default: 0. Where a point
            has no cell they are ignored.

        It is :func:`pyvotess.autodiff.vjp` for frames; derivatives of ``volumes`` and ``face_areas`` are rounded to float32.
        Values are usually right to 1e-5 of the largest; narrow cells of clusters lose digits. Points without a cell have 0.

        VotessError for unresolved cells, see ``resolve()``; ValueError after another call of the same :class:`Frames`.

        >>> gradients = cells.resolve().vjp(volumes=2 * cells.volumes)   # doctest: +SKIP
        """
        given = {
            "volumes": (volumes, np.float32), "centroids": (centroids, np.float64), "face_areas": (face_areas, np.float32),
        }  # fmt: skip
        vectors = [None if array is None else _as_vector(array, name, self, dtype) for name, (array, dtype) in given.items()]
        return self._frames._vjp(self, vectors)

    def __reduce__(self) -> Any:
        raise TypeError("cells of a frame cannot be copied or pickled: copy their arrays")


def _as_vector(values: Any, name: str, cells: FrameCells, dtype: Any) -> npt.NDArray[Any]:
    """Returns derivatives by an array of the cells. AttributeError where they lack it."""
    given, shape = as_float64_or_float32(values, name), getattr(cells, name).shape
    if given.shape != shape:
        raise ValueError(f"{name} has shape {given.shape}: it must be {shape}, that of the array of the cells")
    return np.ascontiguousarray(given, dtype)


class CudaCells:
    """The cells of one call of :class:`Frames` on a device of CUDA, in the order of the N points.

    Arrays have the CUDA Array Interface and DLPack: tensors over votess's memory, without a copy, valid until the next call.
    Those with an entry for each face are longer than the rows, which end at ``indptr[N]``.
    """

    status: Any  #: (N,) int32, values of :class:`CellStatus`
    indptr: Any  #: (N + 1,) int32: row i of the lists is ``indices[indptr[i]:indptr[i+1]]``
    indices: Any  #: int32: neighbors, ascending in each row, walls (negative) first
    shifts: Any  #: (entries, 3) int8 numbers of box vectors, in periodic domains
    face_areas: Any  #: float32, length unit squared
    volumes: Any  #: (N,) float32, with a relative error of at most 1e-5; 0 without a cell
    centroids: Any  #: (N, 3), in the type of the points, of the cells around these as given; or NaN

    def __init__(self, frames: Frames, number: int, count: int, stream: int, ready: int) -> None:
        self._frames, self._number, self._count, self._stream = frames, number, count, stream
        export, entries = frames._export, frames._export.max_entries
        arrays: Dict[str, Any] = {
            "status": ((count,), "<i4"), "indptr": ((count + 1,), "<i4"), "indices": ((entries,), "<i4"),
            "shifts": ((entries, 3), "|i1"), "face_areas": ((entries,), "<f4"), "volumes": ((count,), "<f4"),
            "centroids": ((count, 3), frames._dtype.str),
        }  # fmt: skip
        for name, (shape, dtype) in arrays.items():
            place = getattr(export, name)
            if place != _NONE:
                self.__dict__[name] = frames._array(place, shape, dtype, (ready, stream))

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name, self._frames._wanted if "_frames" in self.__dict__ else None)

    def __len__(self) -> int:
        return self._count

    def __repr__(self) -> str:
        arrays = [name for name in self.__dict__ if not name.startswith("_")]
        return f"<pyvotess.gpu.CudaCells of {counted(len(self), 'point')}: {', '.join(arrays)}>"

    def resolve(self) -> CudaCells:
        """Waits for the cells, makes those that the device left on the CPU, and writes all arrays again.

        Returns this object. ValueError after another call of the same :class:`Frames`.
        """
        self._frames._resolve_on_cuda(self._number, self._stream)
        return self

    def vjp(self, volumes: Any = None, centroids: Any = None, face_areas: Any = None, *, stream: Any = None) -> Gradients:
        """Returns the gradient of a number by points and weights: arrays as those of the cells, valid until the next call.

        The Frames were made with ``gradients=True``. It waits for nothing on the host.

        Parameters
        ----------
        volumes, centroids, face_areas : derivatives of the number by these arrays, on the GPU: float32, for centroids of the
            type of the points. ``face_areas`` may end at ``indptr[N]``. Default: 0. Where a point has no cell they are ignored.
        stream : of CUDA, as for the call. It has written them, and it reads the gradient. Default: that of the call.

        Numbers have the type of the points, and are as right as those of :meth:`FrameCells.vjp`. Points without a cell have 0.
        Those of unresolved cells are NaN, see ``status``: call ``resolve()`` before.

        ValueError after another call of the same :class:`Frames`.
        """
        return self._frames._vjp_on_cuda(self, {"volumes": volumes, "centroids": centroids, "face_areas": face_areas}, stream)


class Frames(OneCallAtATime):
    """Makes cells of up to ``max_points`` points on a Vulkan device, call after call. A context manager.

    The device stays open, with its buffers and its shaders, which may take seconds to compile. A call uploads the points
    and returns a :class:`FrameCells`. Each cell is proven on the device, or its status says why it is not, as for
    ``resolve()``. The results are those of :func:`tessellate`, with sizes in float32.

    Parameters
    ----------
    max_points : of a call, at most 2**27.
    domain, box, periodic, cell, origin, walls : as for :func:`tessellate`: a finite box or a cell, which all calls share.
        Points outside, or not finite, have the status ``OUTSIDE`` and no cell. In a periodic domain points up to one side
        outside are wrapped into it; farther ones count as outside, unlike for :func:`tessellate`.
    want : some of "neighbors", "volumes", "centroids", "areas".
    weights : (least, largest) of all calls, for power diagrams. Each call then takes weights. A point whose weight is
        beyond them has no cell, so choose them as narrow as possible.
    list_walls, threads, k_init, chunk_size : as for :func:`tessellate`.
    device : "auto": a GPU, or a software device where there is none; "gpu", "lavapipe" or an index of :func:`devices`. Points
        and cells are then in the host's memory. "cuda" or "cuda:1": tensors on that GPU; calls return :class:`CudaCells`.
    dtype : of points and weights on a device of CUDA: float32 or float64.
    gradients : True: cells have ``vjp()``. It makes more shaders, and needs "neighbors" in ``want`` and float64. On a device of CUDA the
        memory has room for it.
    follow : keep the cells for the next call: those that still hold are not made again. Arrays stay the same. It pays where
        points move by at most a hundredth of their distance, and takes up to 800 bytes a point. Leave ``chunk_size`` out.
    max_entries : of all rows together; 0: 20 a point. Cells whose rows do not fit stay unresolved.
    margin, max_images : width of the layer of images around a periodic box, and how many it may hold; 0: as suits uniform
        points. Cells that reach farther stay unresolved.
    share : other frames, whose device and shaders these use too. They are made in milliseconds.

    Raises
    ------
    ValueError, TypeError : wrong arguments, which the message names.
    VotessError : no Vulkan device, or a domain that the device cannot hold.

    >>> with vt.gpu.Frames(1000, box=box, periodic=True, want="neighbors,volumes", device="lavapipe") as frames:   # doctest: +SKIP
    ...     cells = frames(points).resolve()
    """

    _kind = "object of Frames"

    @with_short_forms
    def __init__(
        self,
        max_points: int,
        domain: Optional[DomainLike] = None,
        *,
        want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
        weights: Optional[npt.ArrayLike] = None,
        list_walls: bool = False,
        device: str = "auto",
        threads: int = 0,
        k_init: int = 0,
        chunk_size: int = 0,
        max_entries: int = 0,
        margin: float = 0.0,
        max_images: int = 0,
        share: Optional[Frames] = None,
        dtype: npt.DTypeLike = "float32",
        gradients: bool = False,
        follow: bool = False,
        **keywords: Unpack[DomainKeywords],
    ) -> None:
        frames = _c_api.FramesOptions(
            max_points=as_count(max_points, "max_points", 32),
            max_entries=as_count(max_entries, "max_entries", 32),
            margin=as_number(margin, "margin"),
            max_images=as_count(max_images, "max_images", 32),
            gradients=as_flag(gradients, "gradients"),
        )
        if weights is not None:
            limits = as_float64_or_float32(weights, "weights")
            if limits.shape != (2,):
                raise ValueError(f"weights has shape {limits.shape}: give the least and the largest one of all calls")
            frames.has_weights, (frames.least_weight, frames.largest_weight) = 1, limits.tolist()
        if share is not None and not isinstance(share, Frames):
            raise TypeError(f"share is {shown(share)}: give other Frames")
        where = as_domain(domain, keywords)
        self._importer: Any = None
        self._dtype = _as_dtype(dtype)
        on_cuda = isinstance(device, str) and device.startswith("cuda")
        if on_cuda:
            from . import _cuda

            driver, ordinal = _cuda.Driver(), _cuda.as_ordinal(device)
            frames.exported = self._dtype.itemsize
            frames.device_uuid[:] = driver.uuid(ordinal)
            device = "auto"
        options = new_options(
            want=want, list_walls=list_walls, device=device, threads=threads, k_init=k_init, chunk_size=chunk_size,
            follow=follow,
        )  # fmt: skip
        where._fill(options, None)
        self._wanted = implied_words(options)
        self._periodic = any(where.periodic)
        self._lock = threading.Lock()
        self._calls = 0
        self._value = 0  # of the semaphore
        self._handle = Handle.made("frames", lib.votess_frames_new, frames, options, None if share is None else share._open())
        text = ctypes.create_string_buffer(512)
        raise_on_failure(lib.votess_frames_device(self._handle, text, len(text)))
        self._max_points, self._has_weights = frames.max_points, weights is not None
        if on_cuda:
            self._export = _c_api.FramesExport()
            raise_on_failure(lib.votess_frames_get_export(self._handle, self._export))
            self._importer = _cuda.Importer(driver, ordinal, self._export, text.value.decode().split(":")[0], self._handle)
        self._text = f"up to {frames.max_points} points in a {where._text()} on {text.value.decode('utf-8', 'replace')}"

    def _open(self) -> Any:
        """Returns the library's object."""
        if not self._handle.pointer:
            raise ValueError("these Frames are closed")
        return self._handle.pointer

    def __call__(self, points: Any, weights: Any = None, *, stream: Any = None) -> Any:
        """Returns the :class:`FrameCells` of (N, 3) points, float64 or float32: arrays of NumPy, or objects with DLPack on the CPU.

        Frames on a device of CUDA take tensors there, and return :class:`CudaCells`. They wait for nothing on the host.

        weights : (N,) length unit squared, for frames with a range of weights.
        stream : of CUDA, as a handle or an object of PyTorch or CuPy. It has written the points, and it reads the cells.
            Default: that of the CUDA Array Interface of the points, or the default stream.
        """
        if self._importer is not None:
            return self._call_on_cuda(points, weights, stream)
        if stream is not None:
            raise ValueError("stream is of CUDA, but these Frames are not on 'cuda': leave it out")
        array = as_points(points)
        masses = None if weights is None else as_one_each(weights, "weights", len(array), "points")
        function = lib.votess_frames_run_f32 if array.dtype == np.float32 else lib.votess_frames_run
        with self._alone():
            self._calls += 1
            return FrameCells(self, self._calls, Handle.made("frame_cells", function, self._open(), array, masses, len(array)))

    def _resolve(self, number: int) -> Handle:
        with self._alone():
            self._check_last(number, "resolve()")
            return Handle.made("frame_cells", lib.votess_frames_resolve, self._open())

    def _check_last(self, number: int, call: str) -> None:
        if number != self._calls:
            raise ValueError(f"{call} is of the last call of these Frames: call it before the next one")

    def _vjp(self, cells: FrameCells, vectors: List[Any]) -> Gradients:
        points, weights = np.zeros((len(cells), 3)), np.zeros(len(cells))
        with self._alone():
            self._check_last(cells._number, "vjp()")
            raise_on_failure(watched(lib.votess_frames_vjp, self._open(), *vectors, points, weights))
        return Gradients(points, weights)

    def _call_on_cuda(self, points: Any, weights: Any, stream: Any) -> CudaCells:
        from . import _cuda

        given = _cuda.CudaInput(points, "points", (None, 3), self._dtype)
        count = given.shape[0]
        inputs = [("points", given, self._export.points)]
        if (weights is not None) != self._has_weights:
            raise ValueError(
                "weights are missing: give one for each point" if self._has_weights
                else "weights are given, but these Frames have none: make Frames with a range of weights"
            )  # fmt: skip
        if weights is not None:
            inputs.append(("weights", _cuda.CudaInput(weights, "weights", (count,), self._dtype), self._export.weights))
        if count > self._max_points:
            raise ValueError(f"{count} points are more than max_points = {self._max_points}: make Frames for more")
        order = _cuda.as_stream(given.stream or 0 if stream is None else stream)
        with self._alone():
            ready = self._submit(inputs, order, lambda *values: lib.votess_frames_submit(self._open(), count, *values), True)
            return CudaCells(self, self._calls, count, order, ready)

    def _submit(self, inputs: List[Any], order: int, submit: Any, is_new: bool) -> int:
        """Copies inputs, each a name, an array and its place, and submits work on them. Returns the semaphore's value behind it.

        is_new: whether this is a new call of the frames, so that the last one ends.
        """
        self._open()
        for name, array, _ in inputs:
            if array.size:
                self._importer.check(name, array.address, order)
        for _, array, place in inputs:
            if array.size:
                self._importer.copy(place, array.address, array.size, order)
        if is_new:
            self._calls += 1
        # The values: inputs are there, results are there.
        self._value += 2
        self._importer.signal(self._value - 1, order)
        raise_on_failure(watched(submit, self._value - 1, self._value))
        self._importer.wait(self._value, order)
        return self._value

    def _vjp_on_cuda(self, cells: CudaCells, given: Dict[str, Any], stream: Any) -> Gradients:
        from . import _cuda

        bits = {"volumes": "volumes", "centroids": "centroids", "face_areas": "areas"}
        inputs, words = [], 0
        for name, values in given.items():
            if values is None:
                continue
            of: Any = getattr(cells, name)  # AttributeError where want lacks it
            shape = (None,) if name == "face_areas" else of.shape
            array = _cuda.CudaInput(values, name, shape, of.dtype)
            if array.shape[0] > of.shape[0]:
                raise ValueError(f"{name} has shape {array.shape}, but the rows have room for {of.shape[0]} entries")
            inputs.append((name, array, getattr(self._export, "given_" + name)))
            words |= WANT_BITS[bits[name]]
        order = cells._stream if stream is None else _cuda.as_stream(stream)
        with self._alone():
            self._check_last(cells._number, "vjp()")
            ready = self._submit(inputs, order, lambda *values: lib.votess_frames_submit_vjp(self._open(), words, *values), False)
        count, dtype = len(cells), self._dtype.str
        by_points = self._array(self._export.by_points, (count, 3), dtype, (ready, order))
        return Gradients(by_points, self._array(self._export.by_weights, (count,), dtype, (ready, order)))

    def _array(self, place: int, shape: Tuple[int, ...], dtype: str, ready: Any) -> Any:
        from . import _cuda

        size = np.dtype(dtype).itemsize
        strides = (size,) if len(shape) == 1 else ((3 * size, size) if size > 1 else (4, 1))  # shifts have a fourth byte
        return _cuda.CudaArray(self._importer, place, shape, strides, dtype, ready)

    def _resolve_on_cuda(self, number: int, stream: int) -> None:
        with self._alone():
            self._check_last(number, "resolve()")
            pointer = self._open()
            self._importer.synchronize(stream)
            raise_on_failure(watched(lib.votess_frames_resolve_exported, pointer, None))

    def close(self) -> None:
        """Frees device and buffers. Arrays on the host stay, those on a device of CUDA do not. Further calls do nothing."""
        with self._alone():
            if self._importer is not None:
                self._importer.close()
            self._handle.free()

    def __repr__(self) -> str:
        return f"<pyvotess.gpu.Frames of {self._text}>"

    def __reduce__(self) -> Any:
        raise TypeError("Frames cannot be copied or pickled: create other ones")
