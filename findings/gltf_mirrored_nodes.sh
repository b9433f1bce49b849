#!/usr/bin/env bash
# PyVista and MeshLab turn the mirrored parts of a glTF scene inside out, so that two equal boxes have volume 0 together.
#
# Surprise: a node with a negative scale is glTF's way to place a mirror image of a shared mesh. Its triangles wind clockwise
#   then, and a reader that moves the points must reverse them. trimesh writes such a scene and reads it back with volume 12.
#   VTK's reader, by PyVista, and MeshLab move the points only. Each part by itself looks right in PyVista, because it reports
#   volumes without a sign. Signs, normals and unions go wrong. The same scene as .ply, .obj or .stl is right everywhere.
# Versions: trimesh 5.2.0, PyVista 0.49.1, VTK 9.7.2, pymeshlab 2025.7.post1
# Seen: 2026-11
# Do: export without node transforms (trimesh: scene.to_mesh()), or flip the faces of parts whose signed volume is negative.
# Source: glTF 2.0 specification, section 3.7.4, "Instantiation": the determinant of the node's global transform defines the
#   winding order.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 pyvista==0.49.1 vtk==9.7.2 pymeshlab==2025.7.post1 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pymeshlab
import pyvista
import trimesh

print({name: version(name) for name in ("trimesh", "pyvista", "vtk", "pymeshlab")})
box = trimesh.creation.box((1, 2, 3))
mirror = np.diag([-1., 1, 1, 1])
mirror[0, 3] = 5
scene = trimesh.Scene()
scene.add_geometry(box)
scene.add_geometry(box.copy(), transform=mirror)


def by_trimesh(name):
    mesh = trimesh.load_mesh(name)
    return mesh.vertices, mesh.faces


def by_pyvista(name):
    data = pyvista.read(name)
    if isinstance(data, pyvista.MultiBlock):
        data = data.combine().extract_surface(algorithm=None)
    return data.points, data.regular_faces


def by_meshlab(name):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(name)
    if meshes.mesh_number() > 1:
        meshes.generate_by_merging_visible_meshes()  # applies the matrix of each
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


changed = False
for name in ("scene.glb", "scene.gltf", "scene.ply", "scene.obj", "scene.stl"):
    scene.export(name)
    for text, read in (("trimesh", by_trimesh), ("PyVista", by_pyvista), ("MeshLab", by_meshlab)):
        points, triangles = read(name)
        a, b, c = np.asarray(points, float)[triangles].swapaxes(0, 1)
        signed = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        mirrored = a[:, 0] > 2.5
        volumes = signed[~mirrored].sum(), signed[mirrored].sum()
        right = text == "trimesh" or not name.startswith("scene.gl")
        same = np.allclose(volumes, [6, 6 if right else -6], atol=1e-4)
        changed |= not same
        print(f"{name:10} {text:7} box {volumes[0]:.2f}, mirrored box {volumes[1]:.2f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
