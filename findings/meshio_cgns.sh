#!/usr/bin/env bash
# CGNS files of meshio are read by meshio only, and meshio reads those of nobody else.
#
# Surprise: meshio writes tetrahedra as .cgns without an error. VTK and PyVista return no block, with messages that no base
#   was found, and Gmsh stops at the first node: the file lacks the labels of nodes that make an HDF5 file a CGNS file. Hexahedra
#   and triangles are left out without a word. A .cgns of Gmsh, which VTK reads, is refused by meshio: it expects its own names.
# Versions: meshio 5.3.5, Gmsh 4.15.2, VTK 9.7.2, PyVista 0.49.1, h5py 3.16.0
# Seen: 2026-11
# Do: let meshio write .msh and Gmsh convert it to .cgns, or use .vtu.
# Source: CGNS, "File mapping manual", HDF5 implementation (each node has the attributes name, label and type); "Standard
#   Interface Data Structures", Elements_t.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet meshio==5.3.5 gmsh==4.15.2 vtk==9.7.2 pyvista==0.49.1 h5py==3.16.0 numpy==2.4.6

venv/bin/python -W ignore - 2>messages <<'EOF' || { cat messages >&2; exit 1; }
import contextlib
import io
import sys
from importlib.metadata import version

import gmsh
import h5py
import meshio
import numpy as np
import pyvista

print({name: version(name) for name in ("meshio", "gmsh", "vtk", "pyvista", "h5py")})


def by_vtk(name):
    blocks = pyvista.read(name)
    return blocks.combine().n_cells if blocks.n_blocks else 0


def by_meshio(name):
    with contextlib.redirect_stdout(io.StringIO()):
        try:
            return {block.type: len(block.data) for block in meshio.read(name).cells}
        except (Exception, SystemExit):  # its message for a file that it cannot read ends the program
            return "refused"


def by_gmsh(name):
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        gmsh.open(name)
        return sum(map(len, gmsh.model.mesh.getElements(3)[1]))
    except Exception as error:
        return str(error)
    finally:
        gmsh.finalize()


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
gmsh.model.occ.synchronize()
gmsh.option.setNumber("Mesh.SaveAll", 1)
gmsh.model.mesh.generate(3)
count = sum(map(len, gmsh.model.mesh.getElements(3)[1]))
for suffix in ("cgns", "msh"):
    gmsh.write(f"gmsh.{suffix}")
gmsh.finalize()
with contextlib.redirect_stdout(io.StringIO()):
    mesh = meshio.read("gmsh.msh")
rows = np.concatenate([block.data for block in mesh.cells if block.type == "tetra"])
hexahedron = meshio.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
                         [("hexahedron", [range(8)])])
meshio.Mesh(mesh.points, [("tetra", rows)]).write("meshio.cgns")
hexahedron.write("hexahedron.cgns")
labels = []
with h5py.File("meshio.cgns") as file:
    file.visititems(lambda name, node: labels.append("label" in node.attrs))
of_gmsh = by_vtk("gmsh.cgns"), by_meshio("gmsh.cgns"), by_gmsh("gmsh.cgns")
of_meshio = by_vtk("meshio.cgns"), by_meshio("meshio.cgns"), by_gmsh("meshio.cgns")
with h5py.File("hexahedron.cgns") as file:
    kept = len(file["Base/Zone1/GridElements/ElementConnectivity"])
print(f"{count} tetrahedra; file of Gmsh: VTK {of_gmsh[0]} cells, meshio {of_gmsh[1]}, Gmsh {of_gmsh[2]}")
print(f"file of meshio: VTK {of_meshio[0]} cells, meshio {of_meshio[1]}, Gmsh: {of_meshio[2]}; {sum(labels)} of {len(labels)} "
      f"nodes have a label; a hexahedron leaves {kept} arrays")
same = of_gmsh[0] >= count and of_gmsh[1:] == ("refused", count) and of_meshio[:2] == (0, {"tetra": count}) and \
    isinstance(of_meshio[2], str) and not any(labels) and kept == 0
if not same:
    sys.exit("CHANGED")
EOF
