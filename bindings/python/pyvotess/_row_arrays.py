"""The arrays by row that cells of a stream and of a rank have."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Tuple

from ._arrays import RowFields
from ._state import no_attribute


@dataclass(frozen=True, eq=False)
class RowArrays(RowFields):
    """Arrays of N cells, whose rows have some number of entries. Those that are not in ``want`` are None.

    Orders and units are those of :class:`Tessellation`. In the plane, vectors have two components.
    """

    def _listed(self) -> str:
        """Returns the names of the arrays that are there, for a repr."""
        given = [name for name in NAMES if name != "status" and getattr(self, name) is not None]
        return ", ".join(given) or "no measures"

    if not TYPE_CHECKING:  # a type checker would accept any name

        def __getattr__(self, name: str) -> Any:
            raise no_attribute(self, name)


NAMES: Tuple[str, ...] = tuple(field.name for field in fields(RowArrays))
