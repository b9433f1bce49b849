"""The cells along rays, see :meth:`pyvotess.Diagram.trace`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Optional

import numpy as np

from ._arguments import counted
from ._input import as_float64_or_float32

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True, eq=False)
class RayCells:
    """The cells along R rays. Those of ray r are ``seeds[offsets[r]:offsets[r + 1]]``, in order along the ray."""

    offsets: npt.NDArray[np.int64]  #: (R + 1,)
    seeds: npt.NDArray[np.int32]  #: (offsets[R],) the seed of each cell passed
    lengths: npt.NDArray[np.float64]  #: (offsets[R],) the length of the ray in it
    #: (offsets[R], 3) the middle of each piece, minus the place of the seed or image whose cell it is; None unless
    #: requested. (offsets[R], 2) in two dimensions, like all vectors.
    middles: Optional[npt.NDArray[np.float64]] = None
    seed_count: Optional[int] = None  #: N, the number of seeds of the Diagram; None if unknown

    def __len__(self) -> int:
        """R, the number of rays."""
        return len(self.offsets) - 1

    def __repr__(self) -> str:
        return f"<pyvotess.RayCells: {counted(len(self), 'ray')} through {counted(len(self.seeds), 'cell')}>"

    def integrate(self, values: npt.ArrayLike, gradients: Optional[npt.ArrayLike] = None) -> npt.NDArray[np.float64]:
        """Returns the integral along each ray of a field that is linear in each cell: (R,) or (R, m).

        The field is ``value + gradient . (x - seed)`` in the cell of a seed or its image.

        Parameters
        ----------
        values : (N,) or (N, m) real numbers, one row for each seed.
        gradients : (N, 3) or (N, m, 3), after ``trace(..., middles=True)``. Default: 0, so that the integral is the sum
            of value times length.

        Raises
        ------
        ValueError : another number of values, gradients of another shape, or without middles.

        >>> rays = d.trace([(0.1, 0.5, 0.5)], [(0.8, 0, 0)])
        >>> rays.integrate(np.ones(100)).round(6)
        array([0.8])
        """
        of_seeds: npt.NDArray[Any] = as_float64_or_float32(values, "values").astype(np.float64, copy=False)
        least = int(self.seeds.max(initial=-1)) + 1
        count = least if self.seed_count is None else self.seed_count
        if of_seeds.ndim not in (1, 2) or len(of_seeds) < count or (self.seed_count is not None and len(of_seeds) > count):
            raise ValueError(f"values has shape {of_seeds.shape}: give ({count},) or ({count}, m), one row for each seed")
        rays = np.repeat(np.arange(len(self)), np.diff(self.offsets))
        columns = of_seeds.reshape(len(of_seeds), *of_seeds.shape[1:] or (1,)).T
        slopes: Any = None
        middles: Any = self.middles
        if gradients is not None:
            if middles is None:
                raise ValueError("gradients need the middles of pieces: use trace(..., middles=True)")
            slopes = as_float64_or_float32(gradients, "gradients").astype(np.float64, copy=False)
            dimensions = middles.shape[1]
            if slopes.shape != (*of_seeds.shape, dimensions):
                raise ValueError(f"gradients has shape {slopes.shape}: values need {(*of_seeds.shape, dimensions)}")
            slopes = slopes.reshape(len(slopes), len(columns), dimensions)
        out: npt.NDArray[np.float64] = np.empty((len(self), len(columns)))
        for c, column in enumerate(columns):
            means = column[self.seeds]  # of the pieces
            if slopes is not None:
                means += np.einsum("ij,ij->i", slopes[self.seeds, c], middles)
            out[:, c] = np.bincount(rays, means * self.lengths, len(self))
        return out.reshape(len(self), *of_seeds.shape[1:])
