#!/usr/bin/env bash
# trimesh refuses polygons of .off files with a TypeError about strings, and meshio ends the program.
#
# Surprise: MeshLab writes a dodecahedron as .off, with its 12 pentagons, and one with its faces cut into triangles. Open3D and
#   libigl read both. trimesh reads the triangles; with the pentagons it multiplies words that it has not turned into numbers,
#   and raises a TypeError. Quadrilaterals pass. meshio prints "Can only read triangular faces" and calls sys.exit(1), which
#   `except Exception` does not catch; so a loop over files ends there. PyVista reads .off by meshio, and ends as well.
# Versions: trimesh 5.2.0, meshio 5.3.5, PyVista 0.49.1, Open3D 0.20.0 (open3d-cpu), libigl 2.6.3, PyMeshLab 2025.7.post1
# Seen: 2026-11
# Do: read such files by Open3D, or cut the faces before writing; catch SystemExit around meshio.
# Source: Geomview manual, "OFF: Object File Format", where each face has its own number of vertices.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 meshio==5.3.5 pyvista==0.49.1 open3d-cpu==0.20.0 libigl==2.6.3 \
    pymeshlab==2025.7.post1 scipy==1.17.1 numpy==2.4.6
export QT_QPA_PLATFORM=offscreen

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import igl
import meshio
import numpy as np
import open3d
import pymeshlab
import pyvista
import trimesh

print({name: version(name) for name in ("trimesh", "meshio", "pyvista", "open3d-cpu", "libigl", "pymeshlab")})
meshes = pymeshlab.MeshSet()
meshes.create_dodecahedron()
meshes.save_current_mesh("pentagons.off", save_polygonal=True)
meshes.save_current_mesh("triangles.off", save_polygonal=False)
with open("quadrilaterals.off", "w") as file:
    corners = [f"{i // 4} {i // 2 % 2} {i % 2}" for i in range(8)]
    faces = ["4 0 1 3 2", "4 4 6 7 5", "4 0 4 5 1", "4 2 3 7 6", "4 0 2 6 4", "4 1 5 7 3"]
    file.write("\n".join(["OFF", "8 6 0", *corners, *faces, ""]))
sizes = {}
for name in ("pentagons", "triangles", "quadrilaterals"):
    with open(name + ".off") as file:
        lines = [line for line in file.read().split("\n") if line and line[0] != "#"]
    points, count = map(int, lines[1].split()[:2])
    sizes[name] = [int(line.split()[0]) for line in lines[2 + points:2 + points + count]]
print({name: f"{len(sides)} faces of {set(sides)} sides" for name, sides in sizes.items()})


def by_open3d(name):
    return len(open3d.io.read_triangle_mesh(name).triangles)


def by_pyvista(name):
    return pyvista.read(name).n_cells


readers = {
    "trimesh": lambda name: len(trimesh.load_mesh(name).faces), "meshio": lambda name: len(meshio.read(name).cells[0].data),
    "PyVista": by_pyvista, "Open3D": by_open3d, "libigl": lambda name: len(igl.read_triangle_mesh(name)[1])}
stated = {
    "triangles": dict.fromkeys(readers, 36),
    "pentagons": {"trimesh": "TypeError", "meshio": "SystemExit", "PyVista": "SystemExit", "Open3D": 36, "libigl": 36},
    "quadrilaterals": {"trimesh": 12, "meshio": "SystemExit", "PyVista": "SystemExit", "Open3D": 12, "libigl": 12}}
changed = set(sizes["pentagons"]) != {5} or set(sizes["triangles"]) != {3}
for name, expected in stated.items():
    for reader, read in readers.items():
        try:
            seen = read(name + ".off")
        except (Exception, SystemExit) as error:
            seen = type(error).__name__
        same = seen == expected[reader]
        changed |= not same
        print(f"{name}.off by {reader}: {seen}" + ("" if isinstance(seen, str) else " triangles"), "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
