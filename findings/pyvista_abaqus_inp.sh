#!/usr/bin/env bash
# PyVista reads Abaqus .inp files of Gmsh and meshio as empty meshes, without an exception.
#
# Surprise: .inp is the ending of Abaqus and CalculiX, and of AVS UCD. PyVista always reads AVS UCD: a mesh of Gmsh or meshio
#   with 24 tetrahedra has no points and no cells, and bounds from 1e299 to -1e299. Nothing is raised. Its volume is 0. The AVS
#   file of the same mesh is read as it should be.
# Versions: PyVista 0.49.1, VTK 9.7.2, Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: pyvista.from_meshio(meshio.read("a.inp")), or write .msh or .vtu; check n_cells after pyvista.read().
# Source: PyVista manual, "Supported file formats" of pyvista.read() and AVSucdReader. Gmsh manual, "Gmsh file formats": .inp is
#   Abaqus. CalculiX CrunchiX manual, "Input deck format".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyvista==0.49.1 vtk==9.7.2 gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import pyvista

print({name: version(name) for name in ("pyvista", "vtk", "gmsh", "meshio")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
gmsh.model.occ.extrude([(2, square)], 0, 0, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(3, [1])
gmsh.option.setNumber("Mesh.MeshSizeMin", 1)
gmsh.model.mesh.generate(3)
gmsh.write("gmsh.inp")
mesh = meshio.read("gmsh.inp")
tetrahedra = meshio.Mesh(mesh.points, [("tetra", mesh.cells_dict["tetra"])])
tetrahedra.write("meshio.inp", file_format="abaqus")
tetrahedra.write("ucd.inp", file_format="avsucd")
changed = False
for name, kind, empty in (("gmsh.inp", "abaqus", True), ("meshio.inp", "abaqus", True), ("ucd.inp", "avsucd", False)):
    right = pyvista.from_meshio(meshio.read(name, file_format=kind))
    found = pyvista.read(name)
    same = right.n_cells == 24 and abs(right.volume - 1) < 1e-9 and (found.n_points, found.n_cells) == ((0, 0) if empty else
                                                                                                     (right.n_points, 24))
    changed |= not same
    print(f"{name}: meshio reads {right.n_points} points, {right.n_cells} cells, volume {right.volume:.3f}; PyVista {found.n_points} "
          f"points, {found.n_cells} cells, bounds in x {found.bounds[:2]}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
