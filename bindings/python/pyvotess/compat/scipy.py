"""scipy.spatial's Voronoi and Delaunay for three dimensions: ``from pyvotess.compat.scipy import Voronoi, Delaunay``.

Diagrams of scipy are unbounded; those of votess end at a box. Cells that reach a box near the points are computed again in
a box with a margin of at least 2**64 times their extent, until exact arithmetic proves that no vertex is beyond it. Each
class lists further differences. ``QhullError`` is that of SciPy if it is installed.
"""

from typing import TYPE_CHECKING, Any

from ._delaunay import Delaunay
from ._points import qhull_error
from ._voronoi import Voronoi

if TYPE_CHECKING:
    from ._points import QhullError
else:

    def __getattr__(name: str) -> Any:
        if name == "QhullError":  # imports SciPy only on demand
            return qhull_error()
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = ["Delaunay", "QhullError", "Voronoi"]
