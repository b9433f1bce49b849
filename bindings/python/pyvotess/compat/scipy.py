"""scipy.spatial's Voronoi and Delaunay for three dimensions: ``from pyvotess.compat.scipy import Voronoi, Delaunay``.

The diagram of scipy has no bound, that of votess ends at a box. Cells that reach the sides of a box near the points are
made anew in one that leaves 2**64 times their extent around them, or more, until exact arithmetic finds that no vertex
lies beyond it. Each class tells what else differs.
"""

from ._delaunay import Delaunay
from ._unbounded import QhullError
from ._voronoi import Voronoi

__all__ = ["Delaunay", "QhullError", "Voronoi"]
