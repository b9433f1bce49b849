"""The cells along rays, see :meth:`pyvotess.Diagram.trace`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt


@dataclass(frozen=True)
class RayCells:
    """The cells along R rays. Those of ray r are ``seeds[offsets[r]:offsets[r + 1]]``, in order along the ray."""

    offsets: npt.NDArray[np.int64]  #: (R + 1,)
    seeds: npt.NDArray[np.int32]  #: (offsets[R],) the seed of each cell passed
    lengths: npt.NDArray[np.float64]  #: (offsets[R],) the length of the ray in it

    def __len__(self) -> int:
        """R, the number of rays."""
        return len(self.offsets) - 1

    def __repr__(self) -> str:
        return f"<pyvotess.RayCells: {len(self)} rays through {len(self.seeds)} cells>"

    def integrate(self, values: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Returns the integral of values along each ray, the sum of value times length: (R,) or (R, m).

        values : (N,) or (N, m) real numbers, one row for each seed.
        """
        of_seeds: npt.NDArray[Any] = np.asarray(values, np.float64)
        rays = np.repeat(np.arange(len(self)), np.diff(self.offsets))
        columns = of_seeds.reshape(len(of_seeds), -1).T
        sums: Any = [np.bincount(rays, column[self.seeds] * self.lengths, len(self)) for column in columns]
        out: npt.NDArray[np.float64] = np.stack(sums, axis=-1).reshape(len(self), *of_seeds.shape[1:])
        return out
