#!/usr/bin/env bash
# Text meshes of Open3D, libigl, Gmsh, trimesh and MeshLab have too few digits for places far from 0 or for small parts.
#
# Surprise: a round tower of 8 m x 20 m stands at UTM coordinates (500,000 E, 5,400,000 N). In the .obj, .off and text .ply of
#   Open3D, the .ply of libigl and the .off of Gmsh it is a bar of 1.6 times the volume: they write 6 significant digits, which are
#   10 m there. MeshLab's .3mf adds 5 %, trimesh's binary .ply and .glb in float32 0.5 %. At the other end trimesh's .obj has 8
#   decimals and MeshLab's .3mf 6: a ball with a radius of 1e-7 m gains 2.6 % or is lost. The arrays in memory are float64, and
#   nothing is printed. PyVista's and meshio's .obj, trimesh's .off and Open3D's binary .ply keep both.
# Versions: Open3D 0.20.0, libigl 2.6.3, Gmsh 4.15.2, trimesh 5.2.0, PyMeshLab 2025.7.post1, PyVista 0.49.1, meshio 5.3.5
# Seen: 2026-11
# Do: subtract a whole offset and scale to about 1 before writing; or write by meshio, PyVista (.obj) or Open3D (binary .ply).
# Source: manuals of the writers, which state no loss: Open3D "File IO", trimesh "trimesh.exchange", libigl "write_triangle_mesh",
#   Gmsh reference manual "Gmsh file formats", MeshLab "export filters"; PLY, OBJ and OFF set no number of digits.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet open3d==0.20.0 libigl==2.6.3 gmsh==4.15.2 trimesh==5.2.0 pymeshlab==2025.7.post1 \
    pyvista==0.49.1 vtk==9.7.2 meshio==5.3.5 scipy==1.17.1 networkx lxml numpy==2.4.6

venv/bin/python -W ignore - <<'EOF' 2>&1 | grep -v "WARN\|Warning"
import sys
from importlib.metadata import version

import gmsh
import igl
import meshio
import numpy as np
import open3d as o3d
import pymeshlab
import pyvista
import trimesh

print({name: version(name) for name in ("open3d", "libigl", "gmsh", "trimesh", "pymeshlab", "pyvista", "meshio")})


def by_open3d(file, vertices, triangles, **options):
    mesh = o3d.geometry.TriangleMesh(o3d.utility.Vector3dVector(vertices), o3d.utility.Vector3iVector(triangles))
    o3d.io.write_triangle_mesh(file, mesh, **options)


def by_gmsh(file, vertices, triangles):
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    surface = gmsh.model.addDiscreteEntity(2)
    gmsh.model.mesh.addNodes(2, surface, np.arange(1, len(vertices) + 1), vertices.ravel())
    gmsh.model.mesh.addElementsByType(surface, 2, [], (triangles + 1).ravel())
    gmsh.write(file)
    gmsh.finalize()


def by_meshlab(file, vertices, triangles):
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles))
    meshes.save_current_mesh(file)


def by_trimesh(file, vertices, triangles):
    trimesh.Trimesh(vertices, triangles, process=False).export(file)


WRITERS = {"Open3D .obj": by_open3d, "Open3D .off": by_open3d, "Open3D text .ply": lambda *a: by_open3d(*a, write_ascii=True),
           "Open3D .ply": by_open3d,
           "libigl .ply": lambda file, v, t: igl.write_triangle_mesh(file, v, t.astype(np.int64)), "Gmsh .off": by_gmsh,
           "MeshLab .3mf": by_meshlab, "trimesh .ply": by_trimesh, "trimesh .glb": by_trimesh, "trimesh .obj": by_trimesh,
           "trimesh .off": by_trimesh, "PyVista .obj": lambda file, v, t: pyvista.PolyData.from_regular_faces(v, t).save(file),
           "meshio .obj": lambda file, v, t: meshio.Mesh(v, [("triangle", t)]).write(file)}


def volume(vertices, triangles):
    corners = (np.asarray(vertices, float) - np.asarray(vertices, float)[0])[np.asarray(triangles)]
    return np.linalg.det(corners).sum() / 6


tower, ball = trimesh.creation.cylinder(4, 20, sections=32), trimesh.creation.icosphere(3)
STATED = {"tower": {**dict.fromkeys(("Open3D .obj", "Open3D .off", "Open3D text .ply", "libigl .ply", "Gmsh .off"), 1.6018),
                     "MeshLab .3mf": 1.0529, "trimesh .ply": 1.0049, "trimesh .glb": 1.0049},
          "ball": {"MeshLab .3mf": 0, "trimesh .obj": 1.0255}}
changed = False
for name, vertices, triangles in (("tower", tower.vertices + [500005, 5400006, 310], tower.faces),
                                  ("ball", ball.vertices * 1e-7, ball.faces)):
    vertices, triangles = np.array(vertices), np.array(triangles, np.int32)
    right = volume(vertices, triangles)
    for writer, write in WRITERS.items():
        file = name + writer.split()[-1]
        write(file, vertices, triangles)
        read = trimesh.load(file, process=False, force="mesh")
        seen = volume(read.vertices, read.faces) / right
        stated = STATED[name].get(writer, 1)
        same = abs(seen - stated) < 1e-3
        changed |= not same
        print(f"{name}, {writer}: {seen:.4f} of the volume", "" if same else "CHANGED")
sys.exit(changed)
EOF
