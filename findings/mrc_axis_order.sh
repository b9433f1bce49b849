#!/usr/bin/env bash
# SimpleITK and VTK give the axes of an MRC or CCP4 map the spacings of other axes when its columns do not run along x.
#
# Surprise: the header of a map says which axis its columns, rows and sections follow, in mapc, mapr and maps. The cell and its
#   numbers of intervals always follow x, y and z. Many crystallographic maps store z, x, y. SimpleITK and VTK number the axes
#   as they are stored, and pair them with the spacings of x, y and z. A voxel at (4, 3, 12) angstrom comes to (6, 6, 4). The
#   sides of the map, 24, 10 and 12 angstrom, become 12, 15 and 16: a ball becomes an ellipsoid. GridDataFormats and gemmi sort
#   the axes. Nothing warns. Maps stored as x, y, z are right in all of them.
# Versions: SimpleITK 2.5.7, VTK 9.7.2, mrcfile 1.5.4, GridDataFormats 1.2.0, gemmi 0.7.5
# Seen: 2026-12
# Do: sort the axes before, as gemmi's Ccp4Map.setup does, and write the map again.
# Source: MRC2014 format, words 17 to 19 (MAPC, MAPR, MAPS) and 8 to 13 (MX to MZ and cell dimensions). mrcfile manual, "Voxel
#   size", which is in x, y and z.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet simpleitk==2.5.7 vtk==9.7.2 mrcfile==1.5.4 griddataformats==1.2.0 gemmi==0.7.5 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import io
import sys
from importlib.metadata import version
from itertools import permutations

import gemmi
import mrcfile
import numpy as np
import SimpleITK
from gridData import Grid
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkMRCReader

print({name: version(name) for name in ("simpleitk", "vtk", "mrcfile", "griddataformats", "gemmi")})
sizes, spacings, voxel = np.array([5, 4, 6]), np.array([2., 3., 4.]), np.array([2, 1, 3])
right = spacings * voxel


def by_simpleitk(name):
    image = SimpleITK.ReadImage(name)
    index = np.argwhere(SimpleITK.GetArrayFromImage(image) == 1)[0][::-1]
    return image.TransformIndexToPhysicalPoint([int(i) for i in index])


def by_vtk(name):
    reader = vtkMRCReader()
    reader.SetFileName(name)
    reader.Update()
    image = reader.GetOutput()
    return image.GetPoint(int(np.flatnonzero(vtk_to_numpy(image.GetPointData().GetScalars()) == 1)[0]))


def by_griddata(name):
    grid = Grid(name)
    return grid.origin + grid.delta * np.argwhere(grid.grid == 1)[0]


def by_gemmi(name):
    map_ = gemmi.read_ccp4_map(name)
    map_.setup(float("nan"))
    return map_.grid.get_position(*(int(i) for i in np.argwhere(np.array(map_.grid) == 1)[0])).tolist()


changed = False
for axes in permutations(range(3)):  # of columns, rows and sections
    data = np.zeros(sizes[list(axes)][::-1], np.float32)
    data[tuple(voxel[list(axes)][::-1])] = 1
    with mrcfile.new("a.mrc", overwrite=True) as file:
        file.set_data(data)
        header = file.header
        header.mapc, header.mapr, header.maps = (axis + 1 for axis in axes)
        header.mx, header.my, header.mz = sizes
        header.cella = tuple(sizes * spacings)
        assert np.allclose(file.voxel_size.tolist(), spacings)
    report = io.StringIO()
    mrcfile.validate("a.mrc", report) or sys.exit(report.getvalue())
    wrong = spacings * voxel[list(axes)]  # the indices as stored, with the spacings of x, y and z
    found = {read.__name__[3:]: np.round(read("a.mrc"), 4) for read in (by_griddata, by_gemmi, by_simpleitk, by_vtk)}
    same = all(np.allclose(found[name], right, atol=1e-4) for name in ("griddata", "gemmi")) and \
        all(np.allclose(found[name], wrong, atol=1e-4) for name in ("simpleitk", "vtk"))
    changed |= not same
    print("stored as", "".join("xyz"[axis] for axis in axes), {name: place.tolist() for name, place in found.items()}, "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
