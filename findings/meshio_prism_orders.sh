#!/usr/bin/env bash
# meshio turns prisms inside out where it reads .su2 of Gmsh and its own .f3grid and .tec; its other formats keep them.
#
# Surprise: the points of a prism have two orders. .msh, .inp, .bdf, .vtu and .xdmf of Gmsh or meshio give meshio prisms whose
#   triangle (0, 1, 2) faces inward. In .su2 Gmsh writes the other order and meshio keeps it; writing and reading .f3grid
#   (FLAC3D) changes the order, and so does .tec (Tecplot), where prisms become bricks of negative volume. Tetrahedra and
#   hexahedra keep their orientation. All prisms of one file turn, so no check inside a file finds it.
# Versions: Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: look at the sign of the volume of one prism, and permute its points by [0, 2, 1, 3, 5, 4] where it is negative.
# Source: Gmsh manual, "Node ordering". SU2 manual, "Mesh file": elements follow VTK. VTK class reference of version 9.6, vtkWedge.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 meshio==5.3.5 h5py==3.11.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np

print({name: version(name) for name in ("gmsh", "meshio")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)


def orientation(mesh):  # 1 or -1 for each kind of cell, 0 where cells differ: the sign at the first corner
    third = {"tetra": (2, 3), "wedge": (2, 3), "hexahedron": (3, 4)}
    signs = {}
    for block in mesh.cells:
        if block.type in third:
            a, b, c, d = (mesh.points[block.data[:, k]] for k in (0, 1, *third[block.type]))
            found = np.sign(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a))
            signs[block.type] = int(found[0]) if (found == found[0]).all() else 0
    return signs


changed = False
for kind in ("tetra", "hexahedron", "wedge"):
    gmsh.clear()
    square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, square)], 0, 0, 1, [] if kind == "tetra" else [2], recombine=kind != "tetra")
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [1])
    if kind == "hexahedron":
        for _, tag in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(tag)
            gmsh.model.mesh.setRecombine(2, tag)
        gmsh.model.mesh.setTransfiniteVolume(1)
    gmsh.option.setNumber("Mesh.MeshSizeMin", 1)
    gmsh.model.mesh.generate(3)
    found = {}
    for ending in ("msh", "inp", "su2"):
        gmsh.write(f"gmsh.{ending}")
        found[f"gmsh.{ending}"] = orientation(meshio.read(f"gmsh.{ending}"))
    mesh = meshio.read("gmsh.msh")
    plain = meshio.Mesh(mesh.points, [(kind, mesh.cells_dict[kind])])
    for ending in ("bdf", "vtu", "xdmf", "f3grid", "tec"):
        plain.write(f"meshio.{ending}")
        found[f"meshio.{ending}"] = orientation(meshio.read(f"meshio.{ending}"))
    turned = [name for name, signs in found.items() if set(signs.values()) == {-1}]
    kept = [name for name, signs in found.items() if set(signs.values()) == {1}]
    same = turned == (["gmsh.su2", "meshio.f3grid", "meshio.tec"] if kind == "wedge" else []) and len(turned) + len(kept) == 8
    changed |= not same
    print(f"{kind}: inside out in {turned}, right in {kept}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
