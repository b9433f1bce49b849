"""Results as objects of other packages, which are imported on demand."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict

import numpy as np

from ..pairs import make_pairs
from .columns import VTU_NAMES, added_columns, cell_columns, vtu_columns, with_z
from .geometry import POLYGON, POLYHEDRON, mesh_of, polyhedra, with_lengths
from .optional import imported

if TYPE_CHECKING:
    from .._state import SeedCells
    from .columns import Columns


def to_pyvista(t: SeedCells, columns: Columns) -> Any:
    """See :meth:`Tessellation.to_pyvista`."""
    mesh = mesh_of(t, "to_pyvista()", planar=True)
    data = {**vtu_columns(t), **added_columns(t, columns, VTU_NAMES)}
    pyvista = imported("pyvista", "to_pyvista()")
    full = np.diff(mesh.indptr) > 0
    if t.planar:
        words, begin, kind = t.cell_vertex_indices.astype(np.int64), t.cell_vertex_indptr[:-1][full], POLYGON
        begin = np.append(begin, len(words))
    else:
        (words, begin), kind = polyhedra(mesh, np.flatnonzero(full)), POLYHEDRON
    # Each cell follows its number of words, which is 0 for an empty cell.
    lengths = np.zeros(len(t), np.int64)
    lengths[full] = np.diff(begin)
    types = np.where(full, kind, 0).astype(np.uint8)
    if len(t) == 0:  # PyVista refuses arrays without rows
        return pyvista.UnstructuredGrid()
    grid = pyvista.UnstructuredGrid(with_lengths(words, lengths), types, np.array(with_z(mesh.vertices)))
    for name, array in data.items():
        grid.cell_data[name] = np.array(array)
    return grid


def to_dataframe(t: SeedCells) -> Any:
    """See :meth:`Tessellation.to_dataframe`."""
    pandas = imported("pandas", "to_dataframe()")
    columns = {name: np.array(array) for name, array in cell_columns(t).items()}
    index = pandas.RangeIndex(len(t), name="id") if t.ids is None else pandas.Index(np.array(t.ids), name="id")
    return pandas.DataFrame(columns, index=index)


def to_networkx(t: SeedCells) -> Any:
    """See :meth:`Tessellation.to_networkx`."""
    networkx = imported("networkx", "to_networkx()")
    pairs = make_pairs(t)
    # Each face occurs from both sides: as (i, j) and (j, i), or twice as (i, i).
    once = pairs.i <= pairs.j
    i, j = pairs.i[once], pairs.j[once].astype(np.int64)
    keys, which = np.unique(i * max(len(t), 1) + j, return_inverse=True)
    share = np.where(i == j, 0.5, 1.0)
    distance = np.full(len(keys), np.inf)
    np.minimum.at(distance, which, pairs.distance[once])
    values = {"distance": distance.tolist(), "faces": np.bincount(which, share, len(keys)).astype(int).tolist()}
    if pairs.area is not None:
        values["area"] = np.bincount(which, share * pairs.area[once], len(keys)).tolist()
    graph = networkx.Graph()
    nodes = {name: column.tolist() for name, column in cell_columns(t).items()}
    graph.add_nodes_from(zip(range(len(t)), _records(nodes, len(t))))
    first, second = (keys // max(len(t), 1)).tolist(), (keys % max(len(t), 1)).tolist()
    graph.add_edges_from(zip(first, second, _records(values, len(keys))))
    return graph


def network_to_networkx(n: Any) -> Any:
    """See :meth:`Network.to_networkx`."""
    networkx = imported("networkx", "to_networkx()")
    nodes = {**dict(zip("xyz", n.points.T.tolist())), "radius": n.vertex_radii.tolist()}
    values: Dict[str, Any] = {"radius": n.edge_radii.tolist(), "length": n.lengths.tolist()}
    if n.shifts is not None:
        values["shift"] = list(map(tuple, n.shifts.tolist()))
    graph = networkx.MultiGraph()
    graph.add_nodes_from(zip(range(len(n.points)), _records(nodes, len(n.points))))
    graph.add_edges_from(zip(*n.edges.T.tolist(), _records(values, len(n.edges))))
    return graph


def network_to_openpnm(n: Any) -> Any:
    """See :meth:`Network.to_openpnm`."""
    openpnm = imported("openpnm", "to_openpnm()")
    coordinates = np.zeros((len(n.points), 3))
    coordinates[:, : n.points.shape[1]] = n.points
    network = openpnm.network.Network(coords=coordinates, conns=np.array(n.edges))
    network["pore.inscribed_diameter"] = 2 * np.maximum(n.vertex_radii, 0)
    network["throat.inscribed_diameter"] = 2 * np.maximum(n.edge_radii, 0)
    network["throat.length"] = n.lengths
    network["pore.surface"] = np.array(n.at_walls)
    network["throat.periodic"] = np.zeros(len(n.edges), bool) if n.shifts is None else n.shifts.any(axis=1)
    return network


def alpha_to_gudhi(a: Any) -> Any:
    """See :meth:`AlphaComplex.to_gudhi`."""
    tree = imported("gudhi", "to_gudhi()").SimplexTree()
    for rows, values in zip(a.simplices, a.values):
        tree.insert_batch(np.ascontiguousarray(rows.T), np.array(values))
    return tree


def _records(columns: Any, count: int) -> Any:
    """Returns the rows of the columns as dicts."""
    if not columns:
        return ({} for _ in range(count))
    names = tuple(columns)
    return (dict(zip(names, row)) for row in zip(*columns.values()))


def to_freud(t: SeedCells) -> Any:
    """See :meth:`Tessellation.to_freud`."""
    areas = t.face_areas  # raises with the word for want
    freud = imported("freud", "to_freud()", "freud-analysis")
    pairs = make_pairs(t)
    vectors = np.zeros((len(pairs), 3), dtype=np.float32)
    vectors[:, : pairs.vector.shape[1]] = pairs.vector
    return freud.locality.NeighborList.from_arrays(
        len(t),
        len(t),
        pairs.i.astype(np.uint32),
        pairs.j.astype(np.uint32),
        vectors,
        areas[t.neighbors.indices >= 0].astype(np.float32),
    )
