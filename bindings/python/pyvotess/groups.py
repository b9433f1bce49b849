"""Sums of the cells by group, see :meth:`pyvotess.Tessellation.groups`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Optional

from ._arguments import counted
from ._call import Handle
from .mesh import Lists, Neighbors

if TYPE_CHECKING:
    from ._types import Float64Array, Int64Array


@dataclass(frozen=True, eq=False)
class Groups:
    """G groups of the cells, such as molecules or grains. ``groups.neighbors[g]`` are the groups that touch group g."""

    labels: Int64Array  #: (G,) the different labels, ascending
    members: Lists  #: G rows: the seeds of each group, ascending
    #: G rows, ascending: walls (-1, -2, ...) if the rows of the cells list them, then positions in ``labels``. No group is
    #: its own neighbor, not even across a periodic boundary
    neighbors: Neighbors
    counts: Int64Array  #: (E,) the faces of each entry of ``neighbors``
    areas: Optional[Float64Array]  #: (E,) their area; None without "areas" in want
    volumes: Optional[Float64Array]  #: (G,) None without "volumes" in want
    #: (G,) area of the faces to other groups, to walls and to the surface of a mesh; None without "areas,surfaces" in want
    surface_areas: Optional[Float64Array]
    mesh_areas: Optional[Float64Array]  #: (G,) the part on the surface of a mesh; None without "surfaces" and a mesh

    def __len__(self) -> int:
        """G, the number of groups."""
        return len(self.labels)

    def __repr__(self) -> str:
        return f"<pyvotess.Groups: {counted(len(self), 'group')} of {counted(len(self.members.indices), 'cell')}>"


def read_groups(handle: Handle) -> Groups:
    indices = handle.array("indices")

    def sums(name: str, size: int) -> Optional[Float64Array]:
        array = handle.array(name)
        return array if len(array) == size else None

    labels = handle.array("labels")
    return Groups(
        labels=labels,
        members=Lists(handle.array("member_indptr"), handle.array("members")),
        neighbors=Neighbors(handle.array("indptr"), indices),
        counts=handle.array("counts"),
        areas=sums("areas", len(indices)),
        volumes=sums("volumes", len(labels)),
        surface_areas=sums("surface_areas", len(labels)),
        mesh_areas=sums("mesh_areas", len(labels)),
    )
