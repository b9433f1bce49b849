"""Walls around round bodies, for ``walls=`` of :func:`pyvotess.tessellate`.

Each function returns (faces, 4) float64 rows nx, ny, nz, d of planes n.x <= d that touch the body. The polyhedron holds
the whole body and a little more. ``np.concatenate`` joins several bodies.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, List

import numpy as np

from ._arguments import as_count, as_number
from ._call import raise_on_failure
from ._input import as_vector
from ._library import lib

if TYPE_CHECKING:
    import numpy.typing as npt

    from ._types import Float64Array

__all__ = ["cone", "cylinder", "sphere"]


def __dir__() -> List[str]:
    return __all__


def _walls(function: Any, faces: int, *arguments: Any) -> Float64Array:
    count = as_count(faces, "faces", 20)
    rows = np.empty((count, 4))
    raise_on_failure(function(*arguments, count, rows))
    return rows


def sphere(center: npt.ArrayLike, radius: float, faces: int = 300) -> Float64Array:
    """Returns walls around a sphere. They enclose about 3 / faces more of its volume.

    >>> ball = vt.walls.sphere((0.5, 0.5, 0.5), 0.5)
    >>> vt.tessellate(points, box=box, walls=ball, outside="drop").stats.box_volume < 1
    True
    """
    return _walls(lib.votess_sphere_walls, faces, as_vector(center, "center"), as_number(radius, "radius"))


def cylinder(point: npt.ArrayLike, axis: npt.ArrayLike, radius: float, faces: int = 32) -> Float64Array:
    """Returns walls around an infinite cylinder. They enclose about pi**2 / (3 faces**2) more of its cross section.

    >>> vt.walls.cylinder((0.5, 0.5, 0), (0, 0, 1), 0.5).shape[1]
    4
    """
    return _walls(lib.votess_cylinder_walls, faces, as_vector(point, "point"), as_vector(axis, "axis"), as_number(radius, "radius"))


def cone(apex: npt.ArrayLike, axis: npt.ArrayLike, angle: float, faces: int = 32) -> Float64Array:
    """Returns walls around an infinite cone.

    ``axis`` points from the apex into the cone. ``angle``: between axis and surface, radians.

    >>> vt.walls.cone((0, 0, -1), (0, 0, 1), 0.5).shape[1]
    4
    """
    return _walls(lib.votess_cone_walls, faces, as_vector(apex, "apex"), as_vector(axis, "axis"), as_number(angle, "angle"))
