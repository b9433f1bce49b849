#!/usr/bin/env bash
# Gmsh writes prisms of second order to Abaqus .inp as linear prisms with 18 nodes each; meshio reads them as other cells.
#
# Surprise: prisms of order 2 have 18 nodes in Gmsh, by default. In .inp they are `type=C3D6`, whose elements have 6 nodes, and each
#   has 18 on two lines. meshio takes the numbers as they come: 76 prisms instead of 28, made of the numbers of elements too, and
#   prints nothing. The same mesh as .bdf has CPENTA with 18 nodes, which pyNastran refuses with the reason. With
#   Mesh.SecondOrderIncomplete they are C3D15 and CPENTA of 15 nodes in the order of both manuals; pyNastran reads them, and
#   meshio stops with KeyError.
# Versions: Gmsh 4.15.2, meshio 5.3.5, pyNastran 1.4.1
# Seen: 2026-11
# Do: set Mesh.SecondOrderIncomplete before setOrder(2) for .inp and .bdf.
# Source: CalculiX CrunchiX manual, "Six-node wedge element (C3D6 and F3D6)" and "Fifteen-node wedge element (C3D15)". NX Nastran
#   Quick Reference Guide, CPENTA (6 or 15 grid points).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 meshio==5.3.5 pynastran==1.4.1 numpy==1.26.4

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np
from pyNastran.bdf.bdf import read_bdf

print({name: version(name) for name in ("gmsh", "meshio", "pynastran")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
edges = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]  # of C3D15, in the order of its middle nodes


def bad_cells(mesh):  # the number of prisms whose corners enclose nothing, or are inside out
    a, b, c, d = (mesh.points[mesh.cells[0].data[:, k]] for k in range(4))
    return int((np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 1e-9).sum())


def misplaced(file):  # the number of middle nodes of C3D15 that are not in the middle of their edge
    points, cells, section = {}, [], ""
    for line in open(file):
        if line.startswith("*"):
            section = line
        if line.startswith("*") or not (section.startswith("*NODE") or "C3D15" in section):
            continue
        numbers = [float(number) for number in line.split(",") if number.strip()]
        if section.startswith("*NODE"):
            points[int(numbers[0])] = np.array(numbers[1:])
        else:
            cells.append([points[int(k)] for k in numbers[1:]])
    return sum(abs(cell[6 + k] - (cell[i] + cell[j]) / 2).max() > 1e-9 for cell in cells for k, (i, j) in enumerate(edges))


changed = False
for incomplete, written, begin in ((0, ["C3D6"], "76 cells wedge, "), (1, ["C3D15"], "KeyError 'wedge15'")):
    gmsh.clear()
    square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, square)], 0, 0, 1, [2], recombine=True)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1])
    gmsh.option.setNumber("Mesh.MeshSizeMin", .6)
    gmsh.option.setNumber("Mesh.MeshSizeMax", .6)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", incomplete)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    prisms = len(gmsh.model.mesh.getElements(3)[1][0])
    gmsh.write("prisms.inp")
    gmsh.write("prisms.bdf")
    types = [line.split("=")[1].split(",")[0] for line in open("prisms.inp") if line.startswith("*ELEMENT")]
    try:
        mesh = meshio.read("prisms.inp")
        found = f"{len(mesh.cells[0].data)} cells {mesh.cells[0].type}, {bad_cells(mesh)} of them flat or inside out"
    except KeyError as error:
        found = f"KeyError {error}"
    try:
        nastran = sorted({len(element.nodes) for element in read_bdf("prisms.bdf", punch=True, xref=False, debug=None).elements.values()})
    except AssertionError as error:
        nastran = str(error).split("\n")[0]
    same = (prisms == 28 and types == written and found.startswith(begin) and " 0 of" not in found and misplaced("prisms.inp") == 0
            and (nastran == [15] if incomplete else "CPENTA" in str(nastran)))
    changed |= not same
    print(f"Mesh.SecondOrderIncomplete {incomplete}: {prisms} prisms, as {types}; meshio: {found}; pyNastran: {nastran}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
