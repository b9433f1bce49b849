"""tessellate(), the Tessellator that keeps device and buffers, and the list of devices."""

from __future__ import annotations

import ctypes
import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Iterable, List, Optional, Union

from . import _c_api
from ._arguments import shown
from ._arrays import WantName
from ._c_api import DuplicatesWord, PrecisionWord
from ._call import Handle, OneCallAtATime, Progress, raise_on_failure
from ._domain import DomainLike, with_short_forms
from ._library import lib
from ._run import new_options, tessellate_points
from .tessellation import Tessellation

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from ._domain import DomainKeywords


@with_short_forms
def tessellate(
    points: npt.ArrayLike,
    domain: Optional[DomainLike] = None,
    *,
    weights: Optional[npt.ArrayLike] = None,
    radii: Optional[npt.ArrayLike] = None,
    want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
    only: Optional[npt.ArrayLike] = None,
    list_walls: bool = False,
    min_face: float = 0.0,
    min_area: float = 0.0,
    duplicates: DuplicatesWord = "merge",
    progress: Union[None, bool, Progress] = None,
    device: str = "auto",
    threads: int = 0,
    precision: PrecisionWord = "single",
    grid_resolution: int = 0,
    k_init: int = 0,
    chunk_size: int = 0,
    follow: bool = False,
    instructions: str = "",
    **keywords: Unpack[DomainKeywords],
) -> Tessellation:
    """Returns the Voronoi cells of ``points``. The neighbor lists are exact for the given coordinates.

    Parameters
    ----------
    points : (N, 3) array of real numbers, any length unit; N may be 0. Or (N, 2): then the cells are polygons, and
        vectors of the domain and of results have two components, see the page "Two dimensions".
        float64 and float32 in C order are copied; other arrays are converted without loss, also those that have only
        `__dlpack__`. If another thread changes the array during the call, cells are wrong, but nothing crashes.
    domain : the part of space that the cells fill, a :class:`Domain`, or a box alone. Default: the bounds of the points, each
        side moved out by half of (longest side / cbrt(N)). Points outside are an error. Its short forms are arguments too:
        box, periodic, cell, origin, walls, mesh, mesh_repair, mesh_tolerance and outside of :class:`Domain`.
    weights, radii : (N,) numbers for a power diagram, with these weights or the squares of these radii. A seed with an
        empty cell has status EMPTY.
    want : names of arrays of the result, or of groups of them, as a sequence or one string with commas: "volumes",
        "centroids", "counts", "areas", "surface_areas", "faces" and others, see "Names of arrays" on the page "Files". A
        name requests its whole group. Arrays with one row for each neighbor add "neighbors"; "faces" adds "vertices",
        and walls to the rows.
    list_walls : list walls as neighbors too: -1 to -6 = xmin, xmax, ymin, ymax, zmin, zmax of the box, or the faces
        of a cell across a, b and c; -7, -8, ... = walls.
    device : where to run: auto = the first GPU, else the CPU; cpu; gpu = the first GPU; lavapipe = the first Vulkan
        device that is software; or the id of one of devices(). auto is the CPU for fewer than 10,000 points, which
        takes less time than to open a GPU, and if the GPU fails or cannot serve the request. Otherwise a missing device
        is an error.
    precision : "single" or "double"; relative error of volumes, centroids and areas from a GPU: 1e-5 or 1e-10. The
        CPU always reaches 1e-10; the neighbors are exact either way.
    threads : CPU threads, an error if the system gives fewer; 0 = all that it gives (at most 1024).
    grid_resolution : blocks along an axis of the sorting grid; 0 = automatic (at most 1048576).
    k_init : GPU: nearest neighbors tried first for each cell; 0 = automatic (at most 1024).
    chunk_size : GPU: cells in flight at once; 0 = automatic.
    follow : keep the cells for the next frame, or call of a Tessellator: cells that still hold there are not made
        again. Pays on the CPU, where seeds move by at most a hundredth of their distance. Takes some 300 bytes a seed.
    instructions : CPU: baseline, avx2 or avx512; default: the best that the processor has. One that it lacks is an
        error.
    duplicates : "merge" or "error"; points of equal coordinates: the lowest index keeps the cell and the others get
        an empty one, or the input is refused.
    min_face : drop faces between two cells with an area below this share of the mean of all such faces. They leave
        lists, areas, normals, polygons and face counts; walls and vertices stay. The cell of lower index decides for
        both, so lists stay symmetric. 0 drops none.
    min_area : drop faces below this area, as min_face does; the larger limit counts (length unit squared).
    only : the points whose cells to make, as indices or as a mask of N flags. The rows of the result come in this
        order; ``ids`` names their points, and neighbors are indices among all points. Methods for a whole diagram are
        refused. The CPU makes the cells, in the time that they and the sort of all points take.
    progress : True shows a bar of tqdm if it is installed, else a line on stderr. A callable is called about ten times
        a second with the fraction done. If it returns False, the run stops with :class:`VotessError`; its exceptions
        stop the run and reach the caller.

    The GIL is released. Ctrl-C in the main thread stops the run and raises KeyboardInterrupt.

    Raises
    ------
    ValueError : bad input; the message names the first offending index and value.
    MemoryError, VotessError : the run failed; ``VotessError.code`` is UNSUPPORTED for a missing device, DEVICE_LOST
        for one that failed.

    >>> t = vt.tessellate(points, box=box, want="neighbors,volumes")
    >>> print(t.neighbors[0][:3], f"{t.volumes.sum():.6f}")
    [ 4 21 27] 1.000000
    """
    return Tessellation(*tessellate_points(None, new_options(), dict(locals())))


class Tessellator(OneCallAtATime):
    """Keeps device, threads and buffers between calls. A context manager; otherwise freed with the object.

    Use one for points that move from call to call. A result whose arrays are all gone leaves its memory to the next
    one, so calls of the same size allocate nothing.

    The options are those of :func:`tessellate`. Each call checks their limits.

    One call at a time: a second one, from another thread or a progress callback, raises VotessError with code
    INVALID_USE. Results outlive the tessellator, and many threads may read them.

    After a fork (``os.fork``, multiprocessing with the start method "fork") the child may use and close its copy, with
    new CPU threads. A GPU from before the fork raises VotessError with code UNSUPPORTED; device "auto" uses the CPU.

    >>> with vt.Tessellator(device="cpu") as tessellator:
    ...     sums = [tessellator.tessellate(points * k, box=(0, 0, 0, k, k, k)).volumes.sum() for k in (1, 2)]
    >>> print(np.round(sums, 6))
    [1. 8.]
    """

    _kind = "Tessellator"

    def __init__(
        self,
        device: str = "auto",
        threads: int = 0,
        precision: PrecisionWord = "single",
        grid_resolution: int = 0,
        k_init: int = 0,
        chunk_size: int = 0,
        follow: bool = False,
        instructions: str = "",
    ) -> None:
        given = dict(locals())
        del given["self"]
        self._options = new_options(**given)
        self._given = {name: value for name, value in given.items() if value not in (0, "")}
        self._lock = threading.Lock()
        self._handle = Handle.made("tessellator", lib.votess_tessellator_new)

    @with_short_forms
    def tessellate(
        self,
        points: npt.ArrayLike,
        domain: Optional[DomainLike] = None,
        *,
        weights: Optional[npt.ArrayLike] = None,
        radii: Optional[npt.ArrayLike] = None,
        want: Union[str, Iterable[WantName]] = ("neighbors", "volumes"),
        only: Optional[npt.ArrayLike] = None,
        list_walls: bool = False,
        min_face: float = 0.0,
        min_area: float = 0.0,
        duplicates: DuplicatesWord = "merge",
        progress: Union[None, bool, Progress] = None,
        **keywords: Unpack[DomainKeywords],
    ) -> Tessellation:
        """As :func:`tessellate`. ValueError after :meth:`close`.

        >>> with vt.Tessellator() as tessellator:
        ...     tessellator.tessellate(points, box=box, want="volumes")
        <pyvotess.Tessellation of 100 seeds in a box (0, 0, 0) to (1, 1, 1): volumes>
        """
        given = dict(locals())
        del given["self"]
        with self._alone():
            if not self._handle.pointer:
                raise ValueError("this Tessellator is closed")
            options = _c_api.Options.from_buffer_copy(self._options)  # its texts stay owned by the original
            return Tessellation(*tessellate_points(self._handle, options, given))

    def __repr__(self) -> str:
        options = ", ".join(f"{name} {shown(value)}" for name, value in self._given.items())
        return f"<pyvotess.Tessellator{'' if self._handle.pointer else ', closed'}: {options}>"

    def close(self) -> None:
        """Frees device and buffers. Further calls do nothing.

        >>> tessellator = vt.Tessellator()
        >>> tessellator.close()
        """
        with self._alone():
            self._handle.free()

    def __reduce__(self) -> Any:
        raise TypeError("a Tessellator cannot be copied or pickled: create another one")


@dataclass(frozen=True)
class DeviceInfo:
    """A usable device. Pass ``id`` as ``device=``."""

    id: str
    name: str
    description: str  #: limits and features in one line


def devices() -> List[DeviceInfo]:
    """Returns the devices of this machine that votess can use.

    >>> vt.devices()[0].id
    'cpu'
    """
    found = []
    for index in range(lib.votess_device_count()):
        texts = [ctypes.create_string_buffer(size) for size in (256, 256, 4096)]
        sized = [argument for text in texts for argument in (text, len(text))]
        raise_on_failure(lib.votess_device_info(index, *sized))
        found.append(DeviceInfo(*(text.value.decode("utf-8", "replace") for text in texts)))
    return found
