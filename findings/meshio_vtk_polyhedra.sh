#!/usr/bin/env bash
# meshio ends the program when it reads polyhedra of the current VTK; it reads those that it writes itself.
#
# Surprise: VTK 9.4 and later store the faces of polyhedra in new arrays, and mark only such a file as version 2.3. meshio 5.3.5
#   knows 0.1 and 1.0. It exits the process (SystemExit), so that "except Exception" does not see it. The same VTK
#   marks a file of hexahedra as version 0.1, which is read. VTK reads the polyhedra that meshio writes.
# Versions: VTK 9.7.2, meshio 5.3.5
# Seen: 2026-11
# Do: read with VTK 9.4 or later, or catch SystemExit. For other readers write tetrahedra (vtkDataSetTriangleFilter), or the
#   faces as polygons. Look at the version in the first lines before an older reader gets the file.
# Source: VTK documentation, "VTK XML Formats", UnstructuredGrid: face_connectivity, face_offsets, polyhedron_to_faces,
#   polyhedron_offsets. meshio's class ReadError, which its readers raise for files that they refuse.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 meshio==5.3.5 numpy==2.4.6

venv/bin/python - <<'EOF'
import vtk

print("VTK", vtk.vtkVersion.GetVTKVersion())
points = vtk.vtkPoints()
for z in (0, 1):
    for y in (0, 1):
        for x in (0, 1, 2):
            points.InsertNextPoint(x, y, z)


def write(kind, name):
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points)
    for k in (0, 1):
        a, b, c, d = k, k + 1, k + 4, k + 3
        e, f, g, h = a + 6, b + 6, c + 6, d + 6
        corners = vtk.vtkIdList()
        faces = [(a, d, c, b), (e, f, g, h), (a, b, f, e), (b, c, g, f), (c, d, h, g), (d, a, e, h)]
        numbers = [6] + [n for face in faces for n in (4, *face)] if kind == vtk.VTK_POLYHEDRON else [a, b, c, d, e, f, g, h]
        for number in numbers:
            corners.InsertNextId(number)
        grid.InsertNextCell(kind, corners)
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetFileName(name)
    writer.SetInputData(grid)
    writer.Write()


write(vtk.VTK_POLYHEDRON, "polyhedra.vtu")
write(vtk.VTK_HEXAHEDRON, "hexahedra.vtu")
EOF
grep -ao 'VTKFile [^>]*version="[0-9.]*"' polyhedra.vtu hexahedra.vtu

venv/bin/python - <<'EOF'
import sys

import meshio
import numpy as np
import vtk

changed = False


def check(text, seen, stated):
    global changed
    changed |= seen != stated
    print(f"{text}: {seen}", "" if seen == stated else f"CHANGED, was {stated}")


def by_vtk(name):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(name)
    sizes = vtk.vtkCellSizeFilter()
    sizes.SetInputConnection(reader.GetOutputPort())
    sizes.Update()
    volumes = sizes.GetOutput().GetCellData().GetArray("Volume")
    return round(sum(volumes.GetValue(k) for k in range(volumes.GetNumberOfTuples())), 9)


def by_meshio(name):
    try:
        return sum(len(cells.data) for cells in meshio.read(name).cells)
    except BaseException as error:
        return type(error).__name__


print("meshio", meshio.__version__)
corners = [[x, y, z] for z in (0., 1.) for y in (0., 1.) for x in (0., 1.)]
cube = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
meshio.Mesh(np.array(corners), [("polyhedron8", [[np.array(face) for face in cube]])]).write("meshio.vtu")
check("volume of VTK's polyhedra by VTK", by_vtk("polyhedra.vtu"), 2)
check("volume of meshio's polyhedron by VTK", by_vtk("meshio.vtu"), 1)
check("cells of meshio's polyhedron by meshio", by_meshio("meshio.vtu"), 1)
check("cells of VTK's hexahedra by meshio", by_meshio("hexahedra.vtu"), 2)
check("cells of VTK's polyhedra by meshio", by_meshio("polyhedra.vtu"), "SystemExit")
sys.exit(bool(changed))
EOF
