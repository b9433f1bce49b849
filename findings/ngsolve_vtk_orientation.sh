#!/usr/bin/env bash
# NGSolve's VTK files have tetrahedra and hexahedra inside out, or both orientations in one file: volumes -1 and 0.25 for 1.
#
# Surprise: NGSolve writes a unit cube of tetrahedra by VTKOutput. In PyVista and VTK its volume and its integrals are -1, for
#   order 1 and 2, and +1 for order 3. With subdivision=1 each tetrahedron becomes tetrahedra and prisms of opposite orientation:
#   the sum is 0.25. Hexahedra have -1 in all orders. Prisms are right in VTK 9.7, where their order was turned. Netgen's export
#   "Gmsh2 Format" is mirrored too: Gmsh and meshio find -1. NGSolve's own integral is 1, and pictures look right, so
#   nothing shows it before a sum, a flux or a normal.
# Versions: NGSolve and Netgen 6.2.2608, Gmsh 4.15.2, meshio 5.3.5, PyVista 0.49.1, VTK 9.7.2
# Seen: 2026-11
# Do: take absolute values of cell volumes, or swap two corners of each tetrahedron after reading.
# Source: VTK class reference, vtkTetra and vtkHexahedron (the order of their points), and vtkCellSizeFilter. Gmsh manual, "Node
#   ordering". NGSolve manual, VTKOutput (its files are for independent software such as ParaView), subdivision.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ngsolve==6.2.2608 netgen-mesher==6.2.2608 gmsh==4.15.2 meshio==5.3.5 pyvista==0.49.1 vtk==9.7.2 \
    numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import contextlib
import io
import sys
from importlib.metadata import version

import gmsh
import meshio
import numpy as np
import pyvista
from netgen.csg import unit_cube
from netgen.read_gmsh import ReadGmsh
from ngsolve import Integrate, Mesh, VTKOutput

print({name: version(name) for name in ("ngsolve", "netgen-mesher", "gmsh", "meshio", "pyvista", "vtk")})
gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)


def extruded(bricks):  # a unit cube of prisms or of hexahedra, by Gmsh
    gmsh.clear()
    square = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
    gmsh.model.occ.extrude([(2, square)], 0, 0, 1, [2], recombine=True)
    gmsh.model.occ.synchronize()
    if bricks:
        for _, curve in gmsh.model.getEntities(1):
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
        for _, surface in gmsh.model.getEntities(2):
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
        gmsh.model.mesh.setTransfiniteVolume(1)
    gmsh.model.mesh.generate(3)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
    gmsh.write("extruded.msh")
    with contextlib.redirect_stdout(io.StringIO()):
        return ReadGmsh("extruded.msh")


tetrahedra = unit_cube.GenerateMesh(maxh=.5)
meshes = {"tetrahedra": Mesh(tetrahedra), "prisms": Mesh(extruded(False)), "hexahedra": Mesh(extruded(True))}
ways = {"order 1": {}, "order 2": {"order": 2}, "order 3": {"order": 3}, "subdivision 1": {"subdivision": 1}}
stated = {"tetrahedra": (-1, -1, 1, .25), "prisms": (1, 1, 1, 1), "hexahedra": (-1, -1, -1, -1)}
changed = False
for name, mesh in meshes.items():
    found = []
    for way in ways.values():
        VTKOutput(mesh, coefs=[], names=[], filename="out", **way).Do()
        found.append(pyvista.read("out.vtu").compute_cell_sizes()["Volume"].sum())
    same = np.allclose(found, stated[name], atol=1e-6) and abs(Integrate(1, mesh) - 1) < 1e-9
    changed |= not same
    print(f"{name}: volume {Integrate(1, mesh):.6g} by NGSolve; in VTK {', '.join(f'{way} {v:.6g}' for way, v in zip(ways, found))}",
          "" if same else "CHANGED")

tetrahedra.Export("netgen.msh", "Gmsh2 Format")
read = meshio.read("netgen.msh")
corners = read.points[read.cells_dict["tetra"]]
by_meshio = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
gmsh.clear()
gmsh.open("netgen.msh")
by_gmsh = sum(gmsh.model.mesh.getElementQualities(tags, "volume").sum() for tags in gmsh.model.mesh.getElements(3)[1])
same = np.allclose((by_meshio, by_gmsh), -1)
changed |= not same
print(f"Netgen's .msh of the tetrahedra: volume {by_meshio:.6g} by meshio, {by_gmsh:.6g} by Gmsh", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
