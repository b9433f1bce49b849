"""scipy.spatial's Voronoi and Delaunay for three dimensions: ``from pyvotess.compat.scipy import Voronoi, Delaunay``.

The diagram of scipy has no bound, that of votess ends at a box. Cells that reach the sides of a box near the points are
made again in one that leaves 2**64 times their extent around them, or more, until exact arithmetic finds that no vertex
lies beyond it. Each class lists what else differs. ``QhullError`` is SciPy's where SciPy is installed.
"""

from typing import TYPE_CHECKING, Any

from ._delaunay import Delaunay
from ._points import qhull_error
from ._voronoi import Voronoi

if TYPE_CHECKING:
    from ._points import QhullError
else:

    def __getattr__(name: str) -> Any:
        if name == "QhullError":  # SciPy is imported when it is asked for
            return qhull_error()
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = ["Delaunay", "QhullError", "Voronoi"]
