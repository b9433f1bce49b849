#!/usr/bin/env bash
# Netgen reads tetrahedra of second order through meshio with midpoints on the wrong edges: half of the volume.
#
# Surprise: Gmsh makes a cube of tetrahedra of ten points, and a ball. netgen.read_meshio.ReadViaMeshIO() hands the points on in
#   meshio's order, which is that of VTK, where Netgen has another order of the edges. NGSolve integrates 0.52 for 1 over the cube
#   and 2.1 for 4.2 over the ball; elements fold over. Nothing is raised. The same .msh through netgen.read_gmsh.ReadGmsh(), which
#   reorders, is right, and so are tetrahedra of first order through meshio.
# Versions: NGSolve and Netgen 6.2.2608, meshio 5.3.5, Gmsh 4.15.2
# Seen: 2026-11
# Do: ReadGmsh() with a .msh of version 2.2, or .unv by ImportMesh(); compare Integrate(1, mesh) with the known volume.
# Source: netgen.read_meshio, ReadViaMeshIO, which takes any file of meshio and states no restriction. VTK class reference,
#   vtkQuadraticTetra (midpoints on 0-1, 1-2, 2-0, 0-3, 1-3, 2-3). Netgen's order is the one that read_gmsh.py maps to: 0-1, 0-2,
#   0-3, 1-2, 1-3, 2-3.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ngsolve==6.2.2608 netgen-mesher==6.2.2608 meshio==5.3.5 gmsh==4.15.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import contextlib
import io
import sys
from importlib.metadata import version

import gmsh
from netgen.meshing import ImportMesh
from netgen.read_gmsh import ReadGmsh
from netgen.read_meshio import ReadViaMeshIO
from ngsolve import Integrate, Mesh

print({name: version(name) for name in ("ngsolve", "netgen-mesher", "meshio", "gmsh")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.option.setNumber("Mesh.SaveAll", 1)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
gmsh.option.setNumber("Mesh.MeshSizeMin", .5)
gmsh.option.setNumber("Mesh.MeshSizeMax", .5)
changed = False
for shape, order in (("cube", 1), ("cube", 2), ("ball", 2)):
    gmsh.clear()
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1) if shape == "cube" else gmsh.model.occ.addSphere(0, 0, 0, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(order)
    for name in ("a.msh", "a.vtk", "a.unv"):
        gmsh.write(name)
    with contextlib.redirect_stdout(io.StringIO()):
        read = {"ReadGmsh": ReadGmsh("a.msh"), "ImportMesh, .unv": ImportMesh("a.unv"), "meshio, .msh": ReadViaMeshIO("a.msh"),
                "meshio, .vtk": ReadViaMeshIO("a.vtk")}
    volumes = {name: Integrate(1, Mesh(mesh), order=6) for name, mesh in read.items()}
    right = volumes["ReadGmsh"]
    same = abs(right - (1 if shape == "cube" else 4.186)) < .01 and abs(volumes["ImportMesh, .unv"] - right) < 1e-6
    for name in ("meshio, .msh", "meshio, .vtk"):
        same &= abs(volumes[name] - right) < 1e-6 if order == 1 else .4 < volumes[name] / right < .7
    changed |= not same
    print(f"{shape}, order {order}: " + ", ".join(f"{name} {v:.4f}" for name, v in volumes.items()), "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
