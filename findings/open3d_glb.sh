#!/usr/bin/env bash
# Open3D cannot read the .glb that it writes.
#
# Surprise: open3d.io.write_triangle_mesh() puts the numbers of a .glb as base64 into the JSON and writes no binary chunk. Its own
#   read_triangle_mesh() prints a warning of its importer and returns a mesh of 0 triangles instead of an error. MeshLab and
#   trimesh read the file, and so does PyVista after a message that it found no chunk. open3d.t.io.write_triangle_mesh() writes the
#   same mesh with a binary chunk, which all of them read.
# Versions: Open3D 0.20.0, trimesh 5.2.0, PyVista 0.49.1, VTK 9.7.2, PyMeshLab 2025.7.post1
# Seen: 2026-11
# Do: write .glb by open3d.t.io or trimesh, or write .ply.
# Source: glTF 2.0 specification, "GLB File Format Specification", "Binary buffer" (the chunk that the first buffer without uri
#   means); Open3D manual, "File IO" (glb: read and write of triangle meshes).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet open3d==0.20.0 trimesh==5.2.0 pyvista==0.49.1 vtk==9.7.2 pymeshlab==2025.7.post1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF' 2>&1 | grep -v "WARN\|ERR|\|^ERROR"
import struct
import sys
from importlib.metadata import version

import numpy as np
import open3d as o3d
import pymeshlab
import pyvista
import trimesh

print({name: version(name) for name in ("open3d", "trimesh", "pyvista", "vtk", "pymeshlab")})
box = o3d.geometry.TriangleMesh.create_box(1, 2, 3)
o3d.io.write_triangle_mesh("old.glb", box)
o3d.t.io.write_triangle_mesh("tensor.glb", o3d.t.geometry.TriangleMesh.from_legacy(box))


def meshlab(name):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(name)
    return meshes.current_mesh().face_number()


changed = False
for name, chunks, counts in (("old.glb", ["JSON"], (0, 12, 12, 12)), ("tensor.glb", ["JSON", "BIN"], (12, 12, 12, 12))):
    data, at, kinds = open(name, "rb").read(), 12, []
    while at < len(data):
        size, kind = struct.unpack_from("<I4s", data, at)
        kinds.append(kind.rstrip(b"\0").decode())
        at += 8 + size
    seen = (len(o3d.io.read_triangle_mesh(name).triangles), meshlab(name), len(trimesh.load_mesh(name).faces),
            pyvista.read(name).combine().extract_surface().triangulate().n_cells)
    same = kinds == chunks and seen == counts
    changed |= not same
    print(f"{name}: chunks {kinds}; triangles by Open3D {seen[0]}, MeshLab {seen[1]}, trimesh {seen[2]}, PyVista {seen[3]}",
          "" if same else "CHANGED")
sys.exit(changed)
EOF
