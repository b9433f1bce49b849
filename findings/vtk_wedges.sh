#!/usr/bin/env bash
# VTK 9.7 turned the order of the points of a wedge: wedges in files of VTK 9.6, Gmsh and meshio are inside out now.
#
# Surprise: until VTK 9.6 the triangle (0, 1, 2) of vtkWedge faces outward, since 9.7 it faces inward. No file version changed
#   and no reader converts. A wedge of volume 0.5 that VTK 9.6 wrote as .vtu, .vtk or .vtkhdf has -0.5 in 9.7, and conversely.
#   Gmsh and meshio write the old order, and VTK's own reader of OpenFOAM makes it, so prisms of any case have negative volumes.
#   PyVista's from_meshio writes the new one. Inside VTK 9.7, tetrahedra from vtkDataSetTriangleFilter have the old orientation:
#   volume -0.5 for a wedge of 0.5. Quadratic wedges did not change.
# Versions: VTK 9.7.2 and 9.6.2, PyVista 0.49.1, Gmsh 4.15.2, meshio 5.3.5
# Seen: 2026-11
# Do: look at the sign of vtkCellSizeFilter, and permute the points of wedges by [0, 2, 1, 3, 5, 4] where it is negative.
# Source: VTK class reference, vtkWedge: the base is (0, 1, 2) in 9.6 and (0, 2, 1) in 9.7. VTK documentation, "VTK XML Formats"
#   (the version attribute) and "VTK file formats", VTK_WEDGE.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv old
old/bin/pip install --quiet vtk==9.6.2 numpy==2.4.6
"${PYTHON:-python3}" -m venv new
new/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 gmsh==4.15.2 meshio==5.3.5 numpy==2.4.6

cat >wedge.py <<'END'
import os

import vtk

version = vtk.vtkVersion.GetVTKVersion()
readers = {"vtu": vtk.vtkXMLUnstructuredGridReader, "vtk": vtk.vtkUnstructuredGridReader, "vtkhdf": vtk.vtkHDFReader}
writers = {"vtu": vtk.vtkXMLUnstructuredGridWriter, "vtk": vtk.vtkUnstructuredGridWriter, "vtkhdf": vtk.vtkHDFWriter}


def volume(grid):
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputData(grid)
    sizes.Update()
    array = sizes.GetOutput().GetCellData().GetArray("Volume")
    return sum(array.GetValue(k) for k in range(array.GetNumberOfTuples()))


def outward(grid):  # the number of faces of the first cell that look outward
    cell = grid.GetCell(0)
    center = [sum(cell.GetPoints().GetPoint(k)[axis] for k in range(6)) / 6 for axis in range(3)]
    count = 0
    for k in range(5):
        a, b, c = (cell.GetFace(k).GetPoints().GetPoint(j) for j in range(3))
        count += vtk.vtkMath.Determinant3x3(*([q[i] - p[i] for i in range(3)] for p, q in ((center, a), (a, b), (a, c)))) > 0
    return count


def read(name):
    reader = readers[name.split(".")[-1]]()
    reader.SetFileName(name)
    reader.Update()
    return reader.GetOutput()


def write(name, order):
    points = vtk.vtkPoints()
    for k in order:
        points.InsertNextPoint([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)][k])
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.InsertNextCell(vtk.VTK_WEDGE, 6, range(6))
    writer = writers[name.split(".")[-1]]()
    writer.SetFileName(name)
    writer.SetInputData(grid)
    writer.Write()
    return grid


def openfoam():  # a prism as a mesh of OpenFOAM, whose faces look outward, read by VTK
    os.makedirs("case/constant/polyMesh", exist_ok=True)
    patch = "sides { type patch; nFaces 5; startFace 0; }"
    for name, kind, lines in (
            ("points", "vectorField", ["(0 0 0)", "(1 0 0)", "(0 1 0)", "(0 0 1)", "(1 0 1)", "(0 1 1)"]),
            ("faces", "faceList", ["3(0 2 1)", "3(3 4 5)", "4(0 1 4 3)", "4(1 2 5 4)", "4(2 0 3 5)"]),
            ("owner", "labelList", ["0"] * 5), ("neighbour", "labelList", []), ("boundary", "polyBoundaryMesh", [patch])):
        with open(f"case/constant/polyMesh/{name}", "w") as file:
            file.write(f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n{len(lines)}\n(\n" +
                       "\n".join(lines) + "\n)\n")
    open("case/case.foam", "w").close()
    reader = vtk.vtkOpenFOAMReader()
    reader.SetFileName("case/case.foam")
    reader.Update()
    return reader.GetOutput().GetBlock(0)
END

cat >old.py <<'END'
import sys

from wedge import openfoam, outward, read, readers, version, volume, write

changed = volume(openfoam()) != .5
print(f"VTK {version} reads a prism of OpenFOAM: volume {volume(openfoam())}", "CHANGED" if changed else "")
for end in readers:
    if "write" in sys.argv:
        grid = write(f"old.{end}", [0, 2, 1, 3, 5, 4])
        same = volume(grid) == .5 and outward(grid) == 5
        print(f"VTK {version} writes old.{end}: volume {volume(grid)}, {outward(grid)} of 5 faces look outward", end=" ")
    else:
        grid = read(f"new.{end}")
        same = volume(grid) == -.5 and outward(grid) == 0
        print(f"VTK {version} reads new.{end}: volume {volume(grid)}, {outward(grid)} of 5 faces look outward", end=" ")
    changed |= not same
    print("" if same else "CHANGED")
sys.exit(bool(changed))
END

cat >new.py <<'END'
import sys
from importlib.metadata import version as of

import gmsh
import meshio
import numpy as np
import pyvista
import vtk
from wedge import openfoam, outward, read, readers, version, volume, write

print({name: of(name) for name in ("vtk", "pyvista", "gmsh", "meshio")})
changed = False


def check(text, grid, right, faces):
    global changed
    same = np.isclose(volume(grid), right) and (faces is None or outward(grid) == faces)
    changed |= not same
    print(f"{text}: volume {volume(grid):.3g}" + ("" if faces is None else f", {outward(grid)} of 5 faces look outward"),
          "" if same else "CHANGED")


for end in readers:
    check(f"VTK {version} writes new.{end}", write(f"new.{end}", range(6)), .5, 5)
    check(f"VTK {version} reads old.{end}", read(f"old.{end}"), -.5, 0)
check("a prism of OpenFOAM", openfoam(), -.5, 0)
tetrahedra = vtk.vtkDataSetTriangleFilter()
tetrahedra.SetInputData(read("new.vtu"))
tetrahedra.Update()
check("vtkDataSetTriangleFilter of new.vtu", tetrahedra.GetOutput(), -.5, None)
for name in ("old.vtu", "new.vtu", "old.vtk", "new.vtk"):
    text = open(name, "rb").read(200).decode(errors="replace")
    before = 'UnstructuredGrid" version=' if name.endswith("vtu") else "DataFile Version "
    print(name, "states version", text.split(before)[1].split()[0])

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 1)
geo = gmsh.model.geo
line = geo.extrude([(0, geo.addPoint(0, 0, 0))], 1, 0, 0, [2])[1]
square = geo.extrude([line], 0, 1, 0, [2])[1]
cube = geo.extrude([square], 0, 0, 1, [2], recombine=True)[1]
geo.synchronize()
gmsh.model.addPhysicalGroup(3, [cube[1]])
gmsh.model.mesh.generate(3)
for order, right in ((1, -1), (2, 1)):
    gmsh.model.mesh.setOrder(order)
    gmsh.write("gmsh.vtk")
    check(f"a cube of wedges of order {order}, Gmsh's .vtk", read("gmsh.vtk"), right, 0 if order == 1 else None)
    if order == 1:
        gmsh.write("gmsh.msh")
gmsh.finalize()
mesh = meshio.read("gmsh.msh")
mesh = meshio.Mesh(mesh.points, {"wedge": mesh.cells_dict["wedge"]})
mesh.write("meshio.vtu")
check("a cube of wedges of order 1, meshio's .vtu", read("meshio.vtu"), -1, 0)
check("a cube of wedges of order 1, PyVista's from_meshio", pyvista.from_meshio(mesh), 1, 5)
sys.exit(bool(changed))
END

status=0
old/bin/python old.py write || status=1
new/bin/python -W ignore new.py || status=1
old/bin/python old.py read || status=1
exit $status
