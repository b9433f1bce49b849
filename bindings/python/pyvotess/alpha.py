"""The alpha complex, see :meth:`pyvotess.Tessellation.alpha_complex`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional, Sequence, Tuple, Union

import numpy as np

from ._arguments import as_each_axis
from ._call import Handle
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._state import SeedCells
    from ._types import BoolArray, Float64Array, Int8Array, Int32Array, Int64Array


@dataclass(frozen=True, eq=False)
class AlphaComplex:
    """Vertices, edges, triangles and tetrahedra of a Delaunay triangulation, with the values at which they appear.

    Each attribute is a tuple of four arrays, one for each dimension k from 0 to 3. In the plane they are three.
    """

    simplices: Tuple[Int32Array, ...]  #: (M, k + 1) seeds, ascending in each row; rows ascend too
    values: Tuple[Float64Array, ...]  #: (M,) squared radii, as in GUDHI; never less than that of a face
    gabriel: Tuple[BoolArray, ...]  #: (M,) True if no seed lies inside the smallest sphere around the simplex
    shifts: Optional[Tuple[Int8Array, ...]]  #: (M, k + 1, 3) box vectors, 0 for the first seed; None unless periodic
    replicate: Tuple[int, ...]  #: copies of the box along its vectors

    def __repr__(self) -> str:
        counts = ", ".join(str(len(rows)) for rows in self.simplices)
        return f"<pyvotess.AlphaComplex: {counts} simplices of dimension 0 to {len(self.simplices) - 1}>"

    def filtration(self) -> Tuple[Int64Array, Int64Array]:
        """Returns the dimension and the row of each simplex, in the order in which they appear.

        Faces come before the simplices around them. Simplices of equal values are ordered by dimension, then by row.

        >>> a = vt.tessellate(points, box="none", want="faces").alpha_complex()
        >>> dimensions, rows = a.filtration()
        >>> len(rows) == sum(map(len, a.simplices))
        True
        """
        dimensions = np.repeat(np.arange(len(self.simplices)), [len(rows) for rows in self.simplices])
        rows = np.concatenate([np.arange(len(rows)) for rows in self.simplices])
        order = np.argsort(np.concatenate(self.values), kind="stable")
        return dimensions[order], rows[order]

    def to_gudhi(self) -> Any:
        """Returns a gudhi.SimplexTree with the values as filtration.

        >>> a = vt.tessellate(points, box="none", want="faces").alpha_complex()
        >>> a.to_gudhi().num_vertices()
        100
        """
        from .export.packages import alpha_to_gudhi

        return alpha_to_gudhi(self)


def make_alpha(t: SeedCells, result: Handle, replicate: Union[int, Sequence[int]]) -> AlphaComplex:
    points = np.ascontiguousarray(t.points, dtype=np.float64)
    dimensions = t.box.shape[1]
    copies = np.ones(3, np.int32)
    copies[:dimensions] = as_each_axis(replicate, "replicate", dimensions)
    if np.ndim(replicate) == 0 and any(t.periodic):
        copies[:dimensions][~np.array(t.periodic[:dimensions])] = 1
    handle = Handle.made("alpha", lib.votess_alpha_new, result, points, len(points), copies)

    def arrays(name: str) -> Tuple[npt.NDArray[Any], ...]:
        return tuple(handle.array(name, k) for k in range(dimensions + 1))

    shifts = None
    if any(t.periodic):
        shifts = tuple(rows.reshape(-1, k + 1, dimensions) for k, rows in enumerate(arrays("shifts")))
    return AlphaComplex(
        simplices=tuple(rows.reshape(-1, k + 1) for k, rows in enumerate(arrays("seeds"))),
        values=arrays("values"),
        gabriel=tuple(flags.view(np.bool_) for flags in arrays("gabriel")),
        shifts=shifts,
        replicate=tuple(copies[:dimensions].tolist()),
    )
