#!/usr/bin/env bash
# meshio scrambles the points of Gmsh's prisms of second order, or refuses them; other cells of second order are right.
#
# Surprise: meshio orders points as VTK does, and reorders those of a .msh file. It does not know the order of the prism of 18
#   points, which Gmsh makes by default: of nine points on the edges, eight are elsewhere. What meshio writes from it folds
#   over: volume 0.125 for 1 in VTK. The .vtk of the same mesh is read rightly. The prism of 15 points ends in a KeyError,
#   from .msh and .vtk, though its order is known. Tetrahedra and bricks are right.
# Versions: Gmsh 4.15.2, meshio 5.3.5, VTK 9.7.2
# Seen: 2026-11
# Do: index the cells "wedge18" of a .msh by [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16], or read the .vtk.
# Source: Gmsh manual, "Node ordering", Prism18. VTK class reference, vtkBiQuadraticQuadraticWedge (points on edges: 0-1, 1-2,
#   2-0, 3-4, 4-5, 5-3, 0-3, 1-4, 2-5).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 meshio==5.3.5 vtk==9.7.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np
import vtk

print({name: version(name) for name in ("gmsh", "meshio", "vtk")})
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
edges = {  # as VTK orders the points on edges
    "tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
    "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
}
turn = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16]


def extruded(quads, bricks, serendipity):  # a unit cube of one layer along each axis
    gmsh.clear()
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", serendipity)
    geo = gmsh.model.geo
    line = geo.extrude([(0, geo.addPoint(0, 0, 0))], 1, 0, 0, [1])[1]
    square = geo.extrude([line], 0, 1, 0, [1], recombine=quads)[1]
    cube = geo.extrude([square], 0, 0, 1, [1], recombine=bricks)[1]
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [cube[1]])
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write("mesh.msh")
    gmsh.write("mesh.vtk")


def misplaced(points, cells, shape):  # the number of points that are not amid their edge, in the first cell
    places = points[cells[0]]
    corners = {"tetra": 4, "hexahedron": 8, "wedge": 6}[shape]
    return sum(not np.allclose(places[[a, b]].mean(axis=0), places[corners + k]) for k, (a, b) in enumerate(edges[shape]))


def volume(points, kind, cells):
    meshio.Mesh(points, {kind: cells}).write("again.vtu")
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName("again.vtu")
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputConnection(reader.GetOutputPort())
    sizes.Update()
    array = sizes.GetOutput().GetCellData().GetArray("Volume")
    return sum(array.GetValue(k) for k in range(array.GetNumberOfTuples()))


changed = False


def check(text, points, kind, cells, off, right):
    global changed
    seen = misplaced(points, cells, kind.rstrip("0123456789")), volume(points, kind, cells)
    same = kind != "wedge15" and seen[0] == off and np.isclose(seen[1], right)
    changed |= not same
    print(f"{kind:12} {text:18} {seen[0]} points are not amid their edge, volume {seen[1]:.3f}", "" if same else "CHANGED")


for kind, how in (("tetra10", (False, False, 0)), ("hexahedron20", (True, True, 1)), ("hexahedron27", (True, True, 0)),
                  ("wedge15", (False, True, 1)), ("wedge18", (False, True, 0))):
    extruded(*how)
    broken = kind == "wedge18"
    for end in ("msh", "vtk"):
        try:
            mesh = meshio.read(f"mesh.{end}")
        except KeyError as error:
            changed |= kind != "wedge15"
            print(f"{kind:12} from .{end}: KeyError {error}", "" if kind == "wedge15" else "CHANGED")
            continue
        cells = mesh.cells_dict[kind]
        wrong = broken and end == "msh"
        check(f"from .{end}", mesh.points, kind, cells, 8 if wrong else 0, .125 if wrong else 1)
        if wrong:
            check("from .msh, indexed", mesh.points, kind, cells[:, turn], 0, 1)
gmsh.finalize()
sys.exit(bool(changed))
EOF
