#!/usr/bin/env bash
# MeshLab reads the points of big-endian PLY files in double precision with their bytes reversed: a mesh collapses to a point.
#
# Surprise: plyfile writes a cube of side 2 as binary_big_endian with coordinates of type double. trimesh, PyVista and meshio
#   read it. PyMeshLab gives all faces and no warning, but each coordinate is the number of reversed bytes. Whole numbers become
#   some 1e-319, so the cube has no size. Other numbers become any. Float coordinates in big-endian order are right, and so are
#   doubles in little-endian order.
# Versions: PyMeshLab 2025.7.post1, plyfile 1.1.5, trimesh 5.2.0, PyVista 0.49.1, meshio 5.3.5
# Seen: 2026-12
# Do: write little-endian, ASCII or float; or points.byteswap() in NumPy after reading.
# Source: PLY polygon file format, "binary_big_endian" and the type double. plyfile manual, PlyData(byte_order=">").
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pymeshlab==2025.7.post1 plyfile==1.1.5 trimesh==5.2.0 pyvista==0.49.1 vtk==9.7.2 meshio==5.3.5 \
    numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import meshio
import numpy as np
import pymeshlab
import pyvista
import trimesh
from plyfile import PlyData, PlyElement

print({name: version(name) for name in ("pymeshlab", "plyfile", "trimesh", "pyvista", "meshio")})


def by_trimesh(name):
    mesh = trimesh.load(name, process=False)
    return mesh.vertices, mesh.faces


def by_pyvista(name):
    mesh = pyvista.read(name)
    return mesh.points, mesh.regular_faces


def by_meshio(name):
    mesh = meshio.read(name)
    return mesh.points, mesh.cells_dict["triangle"]


def by_pymeshlab(name):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(name)
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


def volume(points, faces):
    return np.linalg.det(points[faces]).sum() / 6


cube = trimesh.creation.box((2, 2, 2))
faces = cube.faces.astype(np.int32)
changed = False
for place, shift in (("whole numbers", 0), ("other numbers", .3)):
    points = np.array(cube.vertices) + shift
    for kind in "f4", "f8":
        for order, sign in (("little", "<"), ("big", ">")):
            vertices = np.empty(len(points), [(axis, kind) for axis in "xyz"])
            for k, axis in enumerate("xyz"):
                vertices[axis] = points[:, k]
            rows = np.empty(len(faces), [("vertex_indices", "i4", (3,))])
            rows["vertex_indices"] = faces
            PlyData([PlyElement.describe(vertices, "vertex"), PlyElement.describe(rows, "face")], byte_order=sign).write("a.ply")
            written = np.column_stack([vertices[axis] for axis in "xyz"])
            others = [read("a.ply") for read in (by_trimesh, by_pyvista, by_meshio)]
            found, kept = by_pymeshlab("a.ply")
            reversed_ = written.astype(float).byteswap()
            right = written if kind == "f4" or order == "little" else reversed_
            same = all(np.allclose(p, written, atol=1e-6) and np.array_equal(f, faces) for p, f in others) and \
                np.array_equal(kept, faces) and np.array_equal(found, right)
            changed |= not same
            print(f"{place}, {kind}, {order}-endian: volumes by the others", *(f"{volume(*other):.4f}" for other in others), end="; ")
            print(f"PyMeshLab: {len(kept)} faces, largest coordinate {np.abs(found).max():.4g}, as reversed bytes "
                  f"{np.array_equal(found, reversed_)}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
