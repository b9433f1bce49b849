#!/usr/bin/env bash
# Gmsh writes MEDIT .mesh files without the prisms and pyramids of the mesh, and skips those that it reads.
#
# Surprise: a cube of prisms and a cube of pyramids: Gmsh writes their points as .mesh, but no prism and no pyramid. meshio reads
#   no cells. The other way, meshio writes the sections Prisms and Pyramids and reads them again; Gmsh opens the file and has
#   no cell of them. No call fails and the log of Gmsh has no warning. Tetrahedra arrive both ways.
# Versions: Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: exchange such meshes as .msh of version 4.1; compare the number of cells, or their volume, after each conversion.
# Source: "LM6 or LM7: mesh file format", manual of libMeshb: the keywords Prisms and Pyramids. Gmsh manual, gmsh.write() and
#   "Gmsh file formats", without a restriction.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np

print({name: version(name) for name in ("gmsh", "meshio")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.logger.start()
corners = {"tetra": 4, "pyramid": 5, "wedge": 6, "hexahedron": 8}
by_gmsh = {4: "tetra", 7: "pyramid", 6: "wedge", 5: "hexahedron"}


def volume(mesh):  # cells are cut into tetrahedra from a corner; the base of a wedge or a pyramid comes first
    cuts = {"tetra": [(0, 1, 2, 3)], "pyramid": [(0, 1, 2, 4), (0, 2, 3, 4)], "wedge": [(0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3)],
            "hexahedron": [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]}
    total = 0
    for block in mesh.cells:
        for cut in cuts.get(block.type, ()):
            a, b, c, d = (mesh.points[block.data[:, k]] for k in cut)
            total += abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6
    return total


def counts(mesh):
    return {name: n for name in corners if (n := sum(len(block.data) for block in mesh.cells if block.type == name))}


def in_gmsh():
    types, tags, _ = gmsh.model.mesh.getElements(3)
    return {by_gmsh[int(kind)]: len(of_kind) for kind, of_kind in zip(types, tags)}


def box(of_prisms):  # a cube of one layer of prisms, or of tetrahedra
    square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, square)], 0, 0, 1, [1] if of_prisms else [], recombine=of_prisms)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 1)
    gmsh.model.mesh.generate(3)


def prisms():
    box(True)


def tetrahedra():
    box(False)


def pyramids():  # a cube of six pyramids
    points = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1, .5, .5, .5]
    bases = [(0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    tag = gmsh.model.addDiscreteEntity(3)
    gmsh.model.mesh.addNodes(3, tag, list(range(1, 10)), points)
    gmsh.model.mesh.addElementsByType(tag, 7, [], [k + 1 for base in bases for k in (*base, 8)])


changed = False
for make, written in ((prisms, 0), (pyramids, 0), (tetrahedra, 1)):
    gmsh.clear()
    make()
    whole = in_gmsh()
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write("gmsh.mesh")
    gmsh.write("gmsh.msh")
    right, found = meshio.read("gmsh.msh"), meshio.read("gmsh.mesh")
    meshio.Mesh(right.points, [block for block in right.cells if block.type in corners]).write("meshio.mesh")
    again = counts(meshio.read("meshio.mesh"))
    gmsh.clear()
    gmsh.open("meshio.mesh")
    opened = in_gmsh()
    kept = {name: n for name, n in whole.items() if name not in ("wedge", "pyramid")}
    same = (abs(volume(right) - 1) < 1e-9 and abs(volume(found) - written) < 1e-9 and whole == counts(right) == again
            and counts(found) == opened == kept)
    changed |= not same
    print(f"{make.__name__}: {whole}; Gmsh's .mesh has {counts(found)}, volume {volume(found):.3g} of {volume(right):.3g}; meshio's has "
          f"{again}, of which Gmsh opens {opened}", "" if same else "CHANGED")
warnings = [line for line in gmsh.logger.get() if line.startswith(("Warning", "Error"))]
changed |= bool(warnings)
print(f"warnings in the log of Gmsh: {warnings}", "CHANGED" if warnings else "")
sys.exit(bool(changed))
EOF
