"""pyvotess: exact 3D and 2D Voronoi tessellation, NumPy in and out.

>>> import numpy as np, pyvotess as vt
>>> points = np.random.default_rng(1).random((100, 3))
>>> box = (0, 0, 0, 1, 1, 1)
>>> t = vt.tessellate(points, box=box, want="faces,volumes,centroids,areas")
>>> print(t.neighbors[0][-3:], t.volumes[0].round(6))
[94 96 98] 0.010952
>>> d = vt.Diagram(points, box=box)

Examples of functions use these names.

See :func:`tessellate` for the options, :class:`Domain` for domains and :class:`Tessellation` for the arrays. Enumerations
and the records of results have help of their own, as ``help(vt.CellStatus)``; ``dir(vt)`` lists them.
"""

from typing import List

from . import autodiff, gpu, walls
from ._c_api import CellStatus as CellStatus, ErrorCode as ErrorCode
from ._call import VotessError
from ._domain import Domain
from ._library import VERSION as __version__
from ._write_frames import write_frames
from .alpha import AlphaComplex
from .atoms import from_ase
from .diagram import Diagram, Probes
from .fields.lloyd import Relaxation as Relaxation, lloyd
from .fields.moments import transport_cost
from .fit import FitError, FitSeconds as FitSeconds, VolumeFit, fit_volumes
from .fields.shapes import Shapes as Shapes
from .frames import Frame, read_frames
from .groups import Groups as Groups
from .masses import Masses
from .mesh import Delaunay, Faces as Faces, Lists as Lists, NaturalCoordinates, Neighbors, Rows as Rows
from .network import FreeSphere as FreeSphere, IncludedSphere as IncludedSphere, Network
from .pairs import Pairs as Pairs
from .pieces import Piece as Piece, Pieces
from .rays import RayCells
from .stats import MeshQuality as MeshQuality, StageSeconds as StageSeconds, Stats as Stats, VerifyReport as VerifyReport
from .stream import StreamResult as StreamResult, StreamRows as StreamRows, tessellate_stream
from .surfaces import Remesh, SurfaceCells, SurfaceRelaxation as SurfaceRelaxation, lloyd_on_surface, remesh, surface
from .tessellation import Tessellation
from .tessellator import DeviceInfo as DeviceInfo, Tessellator, devices, tessellate
from .zones import Zones

__all__ = [
    "AlphaComplex",
    "Delaunay",
    "Diagram",
    "Domain",
    "FitError",
    "Frame",
    "Masses",
    "NaturalCoordinates",
    "Neighbors",
    "Network",
    "Pieces",
    "Probes",
    "RayCells",
    "Remesh",
    "SurfaceCells",
    "Tessellation",
    "Tessellator",
    "VolumeFit",
    "VotessError",
    "Zones",
    "__version__",
    "autodiff",
    "devices",
    "fit_volumes",
    "from_ase",
    "gpu",
    "lloyd",
    "lloyd_on_surface",
    "read_frames",
    "remesh",
    "surface",
    "tessellate",
    "tessellate_stream",
    "transport_cost",
    "walls",
    "write_frames",
]

# Enumerations, and records that results hold. They are public and nobody calls them; help(vt) is shorter without them.
_RECORDS = [
    "CellStatus",
    "DeviceInfo",
    "ErrorCode",
    "Faces",
    "FitSeconds",
    "FreeSphere",
    "Groups",
    "IncludedSphere",
    "Lists",
    "MeshQuality",
    "Pairs",
    "Piece",
    "Relaxation",
    "Rows",
    "Shapes",
    "StageSeconds",
    "Stats",
    "StreamResult",
    "StreamRows",
    "SurfaceRelaxation",
    "VerifyReport",
]


def __dir__() -> List[str]:
    return sorted(__all__ + _RECORDS)
