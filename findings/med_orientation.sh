#!/usr/bin/env bash
# meshio turns every 3D cell of a MED file inside out, both when it reads and when it writes.
#
# Surprise: the points of a MED cell follow the opposite orientation to those of VTK and Gmsh. Gmsh reorders them, and
#   MEDCoupling finds volume +1 for a unit cube that Gmsh wrote. meshio keeps the order of the file: the tetrahedra, hexahedra
#   and wedges of that file have volume -1. The MED files that meshio writes have volume -1 in MEDCoupling and in Gmsh. meshio
#   reads its own files back as they were, so a round trip shows nothing.
# Versions: Gmsh 4.15.2, MEDCoupling 9.15.0, meshio 5.3.5
# Seen: 2026-11
# Do: in meshio, mirror each cell after reading and before writing: [0, 2, 1, 3] for tetrahedra, [0, 3, 2, 1, 4, 7, 6, 5] for
#   hexahedra, [0, 2, 1, 3, 5, 4] for wedges. Or write .msh by Gmsh.
# Source: MEDCoupling manual, "Unstructured mesh" (cells follow the norm of MED files) and MEDCouplingUMesh::getMeasureField
#   (the sign says whether a cell follows it). Gmsh manual, "Node ordering". VTK class reference, vtkTetra and vtkHexahedron,
#   whose order meshio states as its own.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet gmsh==4.15.2 medcoupling==9.15.0 meshio==5.3.5 h5py==3.16.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import gmsh
import medcoupling
import meshio
import numpy as np

print({name: version(name) for name in ("gmsh", "medcoupling", "meshio")})
gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)


def extruded(quads, bricks):  # a unit cube of 2 layers along each axis
    gmsh.clear()
    geo = gmsh.model.geo
    point = geo.addPoint(0, 0, 0)
    line = geo.extrude([(0, point)], 1, 0, 0, [2])[1]
    square = geo.extrude([line], 0, 1, 0, [2], recombine=quads)[1]
    cube = geo.extrude([square], 0, 0, 1, [2], recombine=bricks)[1]
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [cube[1]])
    gmsh.model.mesh.generate(3)


def by_medcoupling(name):
    return medcoupling.MEDFileUMesh(name).getMeshAtLevel(0).getMeasureField(False).accumulate(0)


def by_gmsh(name):
    gmsh.clear()
    gmsh.open(name)
    tags, _ = gmsh.model.mesh.getElementsByType(gmsh.model.mesh.getElementTypes(3)[0])
    return gmsh.model.mesh.getElementQualities(tags, "volume").sum()


def right_handed(mesh, kind):  # the share of cells whose first corner sees its three edges in right-handed order
    corners = mesh.points[mesh.cells_dict[kind]]
    edges = {"tetra": (1, 2, 3), "hexahedron": (1, 3, 4), "wedge": (1, 2, 3)}[kind]
    return np.mean(np.linalg.det(np.stack([corners[:, k] - corners[:, 0] for k in edges], axis=1)) > 0)


changed = False
for kind, quads, bricks in (("tetra", False, False), ("hexahedron", True, True), ("wedge", False, True)):
    extruded(quads, bricks)
    gmsh.write("gmsh.med")
    gmsh.write("gmsh.vtk")
    written = by_medcoupling("gmsh.med"), by_gmsh("gmsh.med")
    vtk = meshio.read("gmsh.vtk")
    shares = right_handed(vtk, kind), right_handed(meshio.read("gmsh.med"), kind)
    meshio.Mesh(vtk.points, {kind: vtk.cells_dict[kind]}).write("meshio.med")
    rewritten = by_medcoupling("meshio.med"), by_gmsh("meshio.med")
    again = right_handed(meshio.read("meshio.med"), kind)
    same = np.allclose(written, 1) and shares == (1, 0) and np.allclose(rewritten, -1) and again == 1
    changed |= not same
    print(f"{kind:10} Gmsh's file: volume {written[0]:.3f} in MEDCoupling, {written[1]:.3f} in Gmsh; right-handed in meshio: "
          f"{shares[1]:.0%}, of Gmsh's .vtk {shares[0]:.0%}", "" if same else "CHANGED")
    print(f"{kind:10} meshio's file: volume {rewritten[0]:.3f} in MEDCoupling, {rewritten[1]:.3f} in Gmsh; right-handed in "
          f"meshio: {again:.0%}")
gmsh.finalize()
sys.exit(bool(changed))
EOF
