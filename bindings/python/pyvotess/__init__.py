"""pyvotess: exact 3D Voronoi tessellation, NumPy in and out.

>>> import numpy as np, pyvotess as vt
>>> points = np.random.default_rng(1).random((100, 3))
>>> box = (0, 0, 0, 1, 1, 1)
>>> t = vt.tessellate(points, box=box, want="faces,volumes,centroids,areas")
>>> print(t.neighbors[0][-3:], t.volumes[0].round(6))
[94 96 98] 0.010952
>>> d = vt.Diagram(points, box=box)

Examples of functions use these names.

See :func:`tessellate` for the options, :class:`Domain` for domains and :class:`Tessellation` for the arrays.
"""

from typing import List

from . import autodiff, gpu, walls
from ._c_api import CellStatus, ErrorCode
from ._call import VotessError
from ._domain import Domain
from ._library import VERSION as __version__
from ._write_frames import write_frames
from .alpha import AlphaComplex
from .atoms import from_ase
from .diagram import Diagram, Probes
from .fields.lloyd import Relaxation, lloyd
from .fields.moments import transport_cost
from .fit import FitError, FitSeconds, VolumeFit, fit_volumes
from .fields.shapes import Shapes
from .frames import Frame, read_frames
from .groups import Groups
from .masses import Masses
from .mesh import Delaunay, Faces, Lists, NaturalCoordinates, Neighbors, Rows
from .network import FreeSphere, IncludedSphere, Network
from .pairs import Pairs
from .pieces import Piece, Pieces
from .rays import RayCells
from .stats import MeshQuality, StageSeconds, Stats, VerifyReport
from .stream import StreamResult, StreamRows, tessellate_stream
from .surfaces import Remesh, SurfaceCells, SurfaceRelaxation, lloyd_on_surface, remesh, surface
from .tessellation import Tessellation
from .tessellator import DeviceInfo, Tessellator, devices, tessellate
from .zones import Zones

__all__ = [
    "AlphaComplex",
    "CellStatus",
    "Delaunay",
    "DeviceInfo",
    "Diagram",
    "Domain",
    "ErrorCode",
    "Faces",
    "FitError",
    "FitSeconds",
    "Frame",
    "FreeSphere",
    "Groups",
    "IncludedSphere",
    "Lists",
    "Masses",
    "MeshQuality",
    "NaturalCoordinates",
    "Neighbors",
    "Network",
    "Pairs",
    "Piece",
    "Pieces",
    "Probes",
    "RayCells",
    "Relaxation",
    "Remesh",
    "Rows",
    "Shapes",
    "StageSeconds",
    "Stats",
    "StreamResult",
    "StreamRows",
    "SurfaceCells",
    "SurfaceRelaxation",
    "Tessellation",
    "Tessellator",
    "VerifyReport",
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


def __dir__() -> List[str]:
    return __all__
