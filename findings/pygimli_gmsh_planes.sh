#!/usr/bin/env bash
# pyGIMLi drops the y axis of flat Gmsh meshes that do not lie at z = 0 or are symmetric: all cells have the area 0.
#
# Surprise: readGmsh finds the axis that a flat mesh lacks by the smallest sum of coordinates. For a mesh in the plane z = 5, or one
#   whose nodes balance about the x axis, that may be y. The nodes then have z for y, so all lie on one line. Nothing is left of 8
#   square meters, in 128 cells with the right numbers of nodes. A section at 240 meters above the sea has y = 240 everywhere. meshio
#   reads the same files right. Nothing warns. Meshes at z = 0 are right unless the sum of y is exactly 0.
# Versions: pyGIMLi 1.6.1, Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: write the mesh at z = 0 and off the axis, gmsh.model.mesh.affineTransform, and move it back with mesh.translate().
# Source: Gmsh manual, "MSH file format version 2": node-number x-coord y-coord z-coord. pyGIMLi manual, pygimli.meshtools.readGmsh: "The
#   file must conform to the MSH ASCII file version 2 format".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pygimli==1.6.1 gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np
from pygimli.meshtools import readGmsh

print({name: version(name) for name in ("pygimli", "gmsh", "meshio")})


def write(corner, sides, even):
    """Writes triangles of a rectangle, with an even grid of nodes or not."""
    gmsh.initialize()
    for option, value in (("General.Terminal", 0), ("Mesh.MshFileVersion", 2.2), ("Mesh.MeshSizeMax", .4)):
        gmsh.option.setNumber(option, value)
    surface = gmsh.model.occ.addRectangle(*corner, *sides)
    gmsh.model.occ.synchronize()
    if even:
        for _, line in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(line, 9)
        gmsh.model.mesh.setTransfiniteSurface(surface)
    gmsh.model.mesh.generate(2)
    gmsh.write("flat.msh")
    gmsh.finalize()


def area(points, triangles):
    a, b, c = (points[triangles[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


changed = False
for corner, even, stated in (((0, 0, 0), True, 8), ((1, 1, 0), False, 8), ((0, -1, 0), True, 0), ((1, 1, 5), False, 0), ((0, -4, -2), False, 8),
                             ((500, 100, 240), False, 0)):
    write(corner, (4, 2), even)
    mesh = meshio.read("flat.msh")
    right = area(mesh.points, mesh.cells_dict["triangle"])
    found = readGmsh("flat.msh")
    y = np.array(found.positions())[:, 1]
    same = abs(right - 8) < 1e-6 and abs(np.sum(found.cellSizes()) - stated) < 1e-6 and found.cellCount() == len(mesh.cells_dict["triangle"])
    changed |= not same
    print(f"corner {corner}, even {even}: area by meshio {right:.4f}, by pyGIMLi {np.sum(found.cellSizes()):.4f} in {found.cellCount()} cells; y "
          f"from {mesh.points[:, 1].min():g} to {mesh.points[:, 1].max():g}, by pyGIMLi {y.min():g} to {y.max():g}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
