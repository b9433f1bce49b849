"""The arrays by row that cells of a stream and of a rank have."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Optional, Tuple

from ._state import no_attribute

if TYPE_CHECKING:
    from ._types import Float64Array, Int8Array, Int64Array, UInt8Array, UInt32Array


@dataclass(frozen=True)
class RowArrays:
    """Arrays of N cells, whose rows have some number of entries. Those that are not in ``want`` are None.

    Orders and units are those of :class:`Tessellation`. In the plane, vectors have two components.
    """

    status: UInt8Array  #: (N,) values of :class:`CellStatus`
    duplicate_of: Optional[Int64Array]  #: (N,) the id of the seed that keeps the cell, or -1; None without duplicates
    shifts: Optional[Int8Array]  #: (entries, 3) numbers of box vectors; None unless periodic
    face_areas: Optional[Float64Array]  #: (entries,) length unit squared
    face_normals: Optional[Float64Array]  #: (entries, 3) unit vectors, outward
    volumes: Optional[Float64Array]  #: (N,) length unit cubed
    centroids: Optional[Float64Array]  #: (N, 3)
    surface_areas: Optional[Float64Array]  #: (N,)
    security_radii: Optional[Float64Array]  #: (N,)
    face_counts: Optional[UInt32Array]  #: (N,)
    edge_counts: Optional[UInt32Array]  #: (N,)
    vertex_counts: Optional[UInt32Array]  #: (N,)

    def _listed(self) -> str:
        """Returns the names of the arrays that are there, for a repr."""
        given = [name for name in NAMES if name != "status" and getattr(self, name) is not None]
        return ", ".join(given) or "no measures"

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name)


NAMES: Tuple[str, ...] = tuple(field.name for field in fields(RowArrays))
