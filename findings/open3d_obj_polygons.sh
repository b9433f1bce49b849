#!/usr/bin/env bash
# Open3D drops the polygons of an .obj.
#
# Surprise: PyVista writes a prism of six sides with two hexagons and six quadrilaterals. open3d.io.read_triangle_mesh() returns
#   a mesh without triangles, with a line of information, and is_watertight() of it is True. If some faces are triangles, only these
#   come: 10 of the 18 of a pyramid over a decagon. The same solids in .ply are complete, and open3d.t.io, trimesh and PyVista
#   read both formats. Voronoi cells, CAD parts and houses are such files.
# Versions: Open3D 0.20.0, PyVista 0.49.1, VTK 9.7.2, trimesh 5.2.0
# Seen: 2026-11
# Do: read by open3d.t.io.read_triangle_mesh(...).to_legacy(), and compare the number of triangles with another reader.
# Source: Wavefront OBJ specification, "Face" (three or more vertices); Open3D manual, "File IO" (obj: read triangle meshes).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet open3d==0.20.0 pyvista==0.49.1 vtk==9.7.2 trimesh==5.2.0 scipy==1.17.1 networkx numpy==2.4.6

venv/bin/python -W ignore - <<'EOF' 2>&1 | grep -v "INFO"
import sys
from importlib.metadata import version

import numpy as np
import open3d as o3d
import pyvista
import trimesh

print({name: version(name) for name in ("open3d", "pyvista", "vtk", "trimesh")})


def ring(corners, height):
    angles = 2 * np.pi * np.arange(corners) / corners
    return np.c_[np.cos(angles), np.sin(angles), np.full(corners, height)]


sides = [[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
prism = np.r_[ring(6, 0), ring(6, 1)], [list(range(6))[::-1], list(range(6, 12)), *sides]
pyramid = np.r_[ring(10, 0), [[0, 0, 1]]], [list(range(10))[::-1], *([k, (k + 1) % 10, 10] for k in range(10))]
changed = False
for name, (vertices, faces), right, stated in (("prism", prism, 20, {"obj": 0, "ply": 20}),
                                               ("pyramid", pyramid, 18, {"obj": 10, "ply": 18})):
    solid = pyvista.PolyData(vertices, np.concatenate([[len(face), *face] for face in faces]))
    for kind in ("obj", "ply"):
        file = f"{name}.{kind}"
        solid.save(file, **({"binary": False} if kind == "ply" else {}))
        mesh = o3d.io.read_triangle_mesh(file)
        others = (len(o3d.t.io.read_triangle_mesh(file).triangle.indices), len(trimesh.load(file, process=False).faces),
                  pyvista.read(file).triangulate().n_cells)
        same = len(mesh.triangles) == stated[kind] and others == (right, right, right)
        changed |= not same
        print(f"{file}: Open3D {len(mesh.triangles)} triangles, watertight {mesh.is_watertight()}; its tensors {others[0]}, "
              f"trimesh {others[1]}, PyVista {others[2]}", "" if same else "CHANGED")
sys.exit(changed)
EOF
