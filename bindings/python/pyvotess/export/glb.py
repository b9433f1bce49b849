"""glTF's binary form: the cells as solids, in the colors of a column."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .geometry import mesh_of, triangles
from .optional import imported

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    UInt8Array = npt.NDArray[np.uint8]


def _linear(srgb: UInt8Array) -> UInt8Array:
    """glTF takes the colors of vertices for linear ones."""
    x = srgb / 255.0
    linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.rint(255 * linear), np.uint8)


def write_glb(path: str, t: Tessellation, colors: UInt8Array) -> None:
    """One mesh of all cells, each with vertices of its own, whose colors (N, 3) they carry.

    Coordinates are float32 there, so they count from the middle of the domain, to which the node moves them.
    """
    trimesh = imported("trimesh", "writing .glb")
    mesh = mesh_of(t, "a .glb file")
    own = t.cell_vertices
    counts = np.diff(own.indptr)
    corners, face = triangles(mesh, np.arange(len(mesh.offsets) - 1))
    cell = mesh.cell_of_face[face]
    # Each cell's vertices ascend, so that pairs (cell, vertex) do, in the order in which they are written.
    span = len(mesh.vertices) + 1
    pairs = np.repeat(np.arange(len(t)), counts) * span + own.indices
    triples = np.searchsorted(pairs, cell[:, None] * span + corners)
    middle = np.asarray(t.box).mean(axis=0)
    rgba = np.column_stack((_linear(colors), np.full(len(t), 255, np.uint8)))
    solid = trimesh.Trimesh(mesh.vertices[own.indices] - middle, triples, process=False)
    # Without a material, viewers show metal, which is dark.
    material = trimesh.visual.material.PBRMaterial(name="cells", metallicFactor=0.0, roughnessFactor=0.9)
    solid.visual = trimesh.visual.TextureVisuals(material=material)
    solid.visual.vertex_attributes["color"] = np.repeat(rgba, counts, axis=0)
    scene = trimesh.Scene()
    move = np.eye(4)
    move[:3, 3] = middle
    scene.add_geometry(solid, node_name="cells", geom_name="cells", transform=move)
    content = scene.export(file_type="glb", include_normals=False)
    with open(path, "wb") as file:
        file.write(content)
