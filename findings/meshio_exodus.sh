#!/usr/bin/env bash
# Hexahedra of second order in meshio's Exodus II files are folded in VTK, and values of cells are missing.
#
# Surprise: Gmsh makes a mesh of hexahedra of 20 or 27 nodes, meshio writes it as .e, and VTK (PyVista, ParaView) reads it. 8 of
#   the 12 edge nodes are then at the middle of another edge. Exodus lists the four vertical edges before those of the top, VTK
#   and meshio after them; VTK's reader permutes them and meshio's writer does not. meshio's reader does not either, so a
#   round trip looks right. Cell data are left out without a word, point data are kept. Tetrahedra of 10 nodes are right.
# Versions: meshio 5.3.5, VTK 9.7.2, PyVista 0.49.1, Gmsh 4.15.2, netCDF4 1.7.5
# Seen: 2026-11
# Do: write .vtu, which both read right; for Exodus, permute nodes 12 to 19 (and the centers of faces) before writing.
# Source: the Exodus II manual, section on element types (figure of HEX: nodes 13 to 16 are on the vertical edges). VTK class
#   reference, vtkQuadraticHexahedron (nodes 12 to 15 are on the top).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet meshio==5.3.5 vtk==9.7.2 pyvista==0.49.1 gmsh==4.15.2 netCDF4==1.7.5.1.post1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import contextlib
import io
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np
import pyvista

print({name: version(name) for name in ("meshio", "vtk", "pyvista", "gmsh", "netCDF4")})
edges = {10: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
         20: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]}
edges[27] = edges[20]
corners = {10: 4, 20: 8, 27: 8}


def by_gmsh(name, hexahedra, incomplete):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", incomplete)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    points = [gmsh.model.geo.addPoint(*p, 0) for p in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lines = [gmsh.model.geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    face = gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(lines)])
    for line in lines:
        gmsh.model.geo.mesh.setTransfiniteCurve(line, 2)
    gmsh.model.geo.mesh.setTransfiniteSurface(face)
    if hexahedra:
        gmsh.model.geo.mesh.setRecombine(2, face)
    gmsh.model.geo.extrude([(2, face)], 0, 0, 1, [1], recombine=hexahedra)
    gmsh.model.geo.synchronize()
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.write(name)
    gmsh.finalize()


def astray(points):
    count = len(points)
    return sum(not np.allclose(points[corners[count] + k], (points[a] + points[b]) / 2)
               for k, (a, b) in enumerate(edges[count]))


changed = False
for nodes, hexahedra, incomplete, stated in ((10, False, 0, 0), (20, True, 1, 8), (27, True, 0, 8)):
    by_gmsh("made.msh", hexahedra, incomplete)
    with contextlib.redirect_stdout(io.StringIO()):
        made = meshio.read("made.msh")
    rows = [block.data for block in made.cells if block.dim == 3]
    kind = [block.type for block in made.cells if block.dim == 3]
    mesh = meshio.Mesh(made.points, list(zip(kind, rows)), cell_data={"value": [np.arange(len(r)) for r in rows]},
                       point_data={"height": made.points[:, 2]})
    found = {}
    for suffix in ("e", "vtu"):
        mesh.write(f"made.{suffix}")
        grid = pyvista.read(f"made.{suffix}")
        grid = grid.combine() if suffix == "e" else grid
        cells = [np.array(cell.points) for cell in grid.cell if cell.dimension == 3]
        assert all(len(points) == nodes for points in cells)
        found[suffix] = max(map(astray, cells)), "value" in grid.cell_data, "height" in grid.point_data
    back = meshio.read("made.e")
    again = max(astray(back.points[row]) for row in back.cells[0].data)
    same = found == {"e": (stated, False, True), "vtu": (0, True, True)} and again == 0 and not back.cell_data
    changed |= not same
    print(f"{kind[0]}: {found['e'][0]} of {len(edges[nodes])} edge nodes astray in VTK's .e, {found['vtu'][0]} in .vtu, {again} "
          f"in meshio's own .e; cell data in .e: {found['e'][1]}, in .vtu: {found['vtu'][1]}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
