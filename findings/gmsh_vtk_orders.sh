#!/usr/bin/env bash
# Gmsh's .vtk files of third order have tetrahedra that fold over, and quadrilaterals and bricks of the wrong type.
#
# Surprise: a straight unit cube of third-order tetrahedra has volume -0.07 in VTK. Gmsh marks the cells as Lagrange tetrahedra
#   and leaves the points on edges and faces in its own order. Quadrilaterals of 16 points and bricks of 64 are marked as the
#   linear types of 4 and 8, so their curvature is lost. Triangles are right, so are all cells of order 2, and so is the CGNS
#   file of the same mesh.
# Versions: Gmsh 4.15.2, VTK 9.7.2, PyVista 0.49.1
# Seen: 2026-11
# Do: write .cgns from Gmsh for order 3, or lower the order first: gmsh.model.mesh.setOrder(2).
# Source: VTK class reference, vtkLagrangeTetra (corners, edges, faces, inside) and vtkCellType (VTK_QUAD 9, VTK_HEXAHEDRON 12,
#   VTK_LAGRANGE_QUADRILATERAL 70, VTK_LAGRANGE_HEXAHEDRON 72). Gmsh manual, "Node ordering".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 vtk==9.7.2 pyvista==0.49.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import numpy as np
import pyvista

print({name: version(name) for name in ("gmsh", "vtk", "pyvista")})
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)


def extruded(kind, order):  # a unit square or cube, with one layer along each axis
    gmsh.clear()
    geo = gmsh.model.geo
    last = (0, geo.addPoint(0, 0, 0))
    solid = kind in ("tetrahedra", "bricks")
    for axis in range(3 if solid else 2):
        last = geo.extrude([last], *np.eye(3)[axis], [1], recombine=kind in ("quadrilaterals", "bricks"))[1]
    geo.synchronize()
    gmsh.model.addPhysicalGroup(last[0], [last[1]])
    gmsh.model.mesh.generate(last[0])
    gmsh.model.mesh.setOrder(order)
    return "Volume" if solid else "Area"


def misfit(cell):  # the largest distance between a point and its place by the shape functions of a straight cell
    places = np.array([cell.GetParametricCoords()[k] for k in range(3 * cell.n_points)]).reshape(-1, 3)
    ones = np.c_[places, np.ones(len(places))]
    return abs(ones @ np.linalg.lstsq(ones, cell.points, rcond=None)[0] - cell.points).max()


changed = False
for kind, linear, lagrange, size in (("triangles", 5, 69, 1), ("quadrilaterals", 9, 70, 1),
                                     ("tetrahedra", 10, 71, -2 / 27), ("bricks", 12, 72, 1)):
    for order in (2, 3):
        measure = extruded(kind, order)
        for end in ("vtk", "cgns"):
            gmsh.write(f"mesh.{end}")
            grid = pyvista.read(f"mesh.{end}")
            grid = grid.combine() if isinstance(grid, pyvista.MultiBlock) else grid
            seen = grid.compute_cell_sizes()[measure].sum()
            number, points = int(grid.celltypes[0]), grid.get_cell(0).n_points
            apart = misfit(grid.get_cell(0)) if number != linear else np.nan
            broken = order == 3 and end == "vtk" and kind != "triangles"
            if broken and kind != "tetrahedra":
                same = number == linear and np.isclose(seen, 1)
            else:
                same = (order == 2 or number == lagrange) and np.isclose(seen, size if broken else 1) and (apart > .1) == broken
            changed |= not same
            print(f"{kind:14} of order {order}, .{end:4} type {number:2} of {points:2} points, {measure.lower()} {seen:6.3f}, "
                  f"points off by {apart:.3f}", "" if same else "CHANGED")
gmsh.finalize()
sys.exit(bool(changed))
EOF
