"""scipy.spatial's Voronoi and Delaunay for two and three dimensions.

Use ``from pyvotess.compat.scipy import Voronoi, Delaunay``. Each class lists its differences. ``QhullError`` is that of
SciPy if it is installed. Points whose coordinates differ by more than 50 orders of magnitude are refused: see the
box ``"none"`` of :func:`pyvotess.tessellate`.
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
