"""glTF's binary form: the cells as solids, in the colors of a column. ``cli/write/write_glb.cpp`` writes the same."""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, NamedTuple, Tuple

import numpy as np

from .geometry import Mesh, mesh_of, triangles

if TYPE_CHECKING:
    import numpy.typing as npt

    from ..tessellation import Tessellation

    Array = npt.NDArray[Any]
    UInt8Array = npt.NDArray[np.uint8]

_LARGEST_FILE = 2**32 - 1  # bytes: the format counts in 32 bits
_SHORT_VERTICES = 65535  # of a chunk whose indices take two bytes; 65535 itself is not an index


def _linear(srgb: UInt8Array) -> UInt8Array:
    """glTF takes the colors of vertices for linear ones."""
    x = srgb / 255.0
    linear = np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.rint(255 * linear), np.uint8)


class _Chunk(NamedTuple):
    """Consecutive cells: one primitive of the mesh."""

    cells: slice
    vertices: int
    indices: int
    lower: Array  #: of the positions, float32
    upper: Array

    @property
    def index_type(self) -> np.dtype[Any]:
        return np.dtype("<u2" if self.vertices <= _SHORT_VERTICES else "<u4")


class _Writer:
    def __init__(self, t: Tessellation, colors: UInt8Array):
        self._mesh: Mesh = mesh_of(t, "a .glb file")
        self._own = t.cell_vertices
        self._rgba = np.column_stack((_linear(colors), np.full(len(t), 255, np.uint8)))
        self._middle = np.asarray(t.box).mean(axis=0)
        self.chunks = [self._chunk(cells) for cells in self._ranges()]

    def _ranges(self) -> Iterator[slice]:
        """The cells of each chunk: as many as short indices can count, but at least one."""
        ends = self._own.indptr[1:]
        begin, count = 0, len(ends)
        while begin < count:
            before = int(self._own.indptr[begin])
            end = max(int(np.searchsorted(ends, before + _SHORT_VERTICES, side="right")), begin + 1)
            if int(self._own.indptr[end]) > before:
                yield slice(begin, end)
            begin = end

    def _chunk(self, cells: slice) -> _Chunk:
        positions = self._positions(cells)
        faces = slice(self._mesh.indptr[cells.start], self._mesh.indptr[cells.stop])
        sizes = np.diff(self._mesh.offsets[faces.start : faces.stop + 1])
        indices = 3 * int(np.maximum(sizes - 2, 0).sum())
        return _Chunk(cells, len(positions), indices, positions.min(axis=0), positions.max(axis=0))

    def _numbers(self, cells: slice) -> Array:
        """Of the vertices of these cells, cell by cell."""
        numbers: Array = self._own.indices[self._own.indptr[cells.start] : self._own.indptr[cells.stop]]
        return numbers

    def _positions(self, cells: slice) -> Array:
        """From the middle of the domain, as float32 has few digits, and with y up, as glTF demands.

        z becomes y, and y becomes -z. That is a rotation, so faces keep their fronts. Programs with z up turn it back.
        """
        x, y, z = (self._mesh.vertices[self._numbers(cells)] - self._middle).T
        return np.column_stack((x, z, -y)).astype("<f4")

    def _indices(self, chunk: _Chunk) -> Array:
        first, last = self._mesh.indptr[chunk.cells.start], self._mesh.indptr[chunk.cells.stop]
        corners, face = triangles(self._mesh, np.arange(first, last))
        cell = np.searchsorted(self._mesh.indptr, face, side="right") - 1
        # Vertices ascend within a cell, so that pairs (cell, vertex) do, in the order in which they are written.
        span = len(self._mesh.vertices) + 1
        counts = np.diff(self._own.indptr[chunk.cells.start : chunk.cells.stop + 1])
        cells = np.arange(chunk.cells.start, chunk.cells.stop)
        pairs = np.repeat(cells, counts) * span + self._numbers(chunk.cells)
        indices: Array = np.searchsorted(pairs, cell[:, None] * span + corners).astype(chunk.index_type)
        return indices

    def arrays(self, chunk: _Chunk) -> List[Array]:
        """Positions, colors, rows and indices."""
        counts = np.diff(self._own.indptr[chunk.cells.start : chunk.cells.stop + 1])
        rows = np.repeat(np.arange(chunk.cells.start, chunk.cells.stop), counts)
        return [self._positions(chunk.cells), self._rgba[rows], rows.astype("<f4"), self._indices(chunk)]

    def head(self) -> Tuple[bytes, int]:
        """The JSON, and how many bytes of arrays follow."""
        from .._library import VERSION

        head: Dict[str, Any] = {"asset": {"version": "2.0", "generator": f"pyvotess {VERSION}"}}
        place = 0
        views: List[Dict[str, Any]] = []
        accessors: List[Dict[str, Any]] = []
        primitives: List[Dict[str, Any]] = []

        def add(count: int, size: int, target: int, **kind: Any) -> int:
            nonlocal place
            views.append({"buffer": 0, "byteOffset": place, "byteLength": count * size, "target": target})
            accessors.append({"bufferView": len(accessors), "count": count, **kind})
            place += -(-count * size // 4) * 4
            return len(accessors) - 1

        for chunk in self.chunks:
            n, size = chunk.vertices, chunk.index_type.itemsize
            bounds = {"min": chunk.lower.tolist(), "max": chunk.upper.tolist()}
            attributes = {
                "POSITION": add(n, 12, 34962, componentType=5126, type="VEC3", **bounds),
                "COLOR_0": add(n, 4, 34962, componentType=5121, normalized=True, type="VEC4"),
                "_CELL": add(n, 4, 34962, componentType=5126, type="SCALAR"),
            }
            kind = {2: 5123, 4: 5125}[size]
            indices = add(chunk.indices, size, 34963, componentType=kind, type="SCALAR")
            primitives.append({"attributes": attributes, "indices": indices, "material": 0})
        if primitives:  # an array of the format holds at least one number
            x, y, z = self._middle.tolist()
            # Without a material, viewers show metal, which is dark.
            look = {"metallicFactor": 0, "roughnessFactor": 0.9}
            head.update(
                scene=0,
                scenes=[{"nodes": [0]}],
                nodes=[{"mesh": 0, "name": "Voronoi cells", "translation": [x, z, -y]}],
                meshes=[{"name": "Voronoi cells", "primitives": primitives}],
                materials=[{"name": "cells", "pbrMetallicRoughness": look}],
                accessors=accessors,
                bufferViews=views,
                buffers=[{"byteLength": place}],
            )
        text = json.dumps(head, separators=(",", ":")).encode()
        return text + b" " * (-len(text) % 4), place


def write_glb(path: str, t: Tessellation, colors: UInt8Array) -> None:
    """One mesh of all cells in the colors (N, 3).

    Each cell is a closed solid with vertices of its own, which carry its color and its row (_CELL). There are no
    normals: readers shade a mesh without normals flat, as the format demands. ValueError when the file would be too large.
    """
    writer = _Writer(t, colors)
    head, arrays_bytes = writer.head()
    size = 20 + len(head) + (8 + arrays_bytes if writer.chunks else 0)
    if size > _LARGEST_FILE:
        raise ValueError(
            f"the .glb file would take {-(-size // 10**6)} MB, but .glb ends at 4 GiB: "
            "write .vtu, which has no limit, or fewer cells"
        )
    with open(path, "wb") as file:
        file.write(struct.pack("<4sIII4s", b"glTF", 2, size, len(head), b"JSON") + head)
        if writer.chunks:
            file.write(struct.pack("<I4s", arrays_bytes, b"BIN\0"))
        for chunk in writer.chunks:
            for array in writer.arrays(chunk):
                file.write(array.tobytes())
                file.write(b"\0" * (-array.nbytes % 4))
