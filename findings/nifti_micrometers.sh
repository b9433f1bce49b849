#!/usr/bin/env bash
# NIfTI images in micrometers are 1000 times larger in NiBabel, VTK and PyVista than in SimpleITK.
#
# Surprise: a NIfTI header states its unit of length: meters, millimeters or micrometers, as scanners for small samples write.
#   SimpleITK converts all to millimeters. NiBabel's affine, VTK and PyVista take the numbers as they are. A voxel of 10 by 20
#   by 30 micrometers has a volume of 6e-6 cubic millimeters in SimpleITK and 6000 in the others. What SimpleITK writes again is
#   in millimeters, so a mask that went through it no longer lies on its image: centers differ by a factor of 1000. Nothing
#   warns. NiBabel has the unit in header.get_xyzt_units(), but neither its affine nor voxel_sizes uses it.
# Versions: NiBabel 5.4.2, SimpleITK 2.5.7, VTK 9.7.2, PyVista 0.49.1
# Seen: 2026-12
# Do: in NiBabel, multiply the affine by the unit; in PyVista, spacing and origin. Or write images in millimeters.
# Source: NIfTI-1 standard, "Units of spatial and temporal dimensions" (xyzt_units, NIFTI_UNITS_MICRON). NiBabel manual,
#   "Coordinate systems and affines", where the affine leads to millimeters.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet nibabel==5.4.2 simpleitk==2.5.7 vtk==9.7.2 pyvista==0.49.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import nibabel
import numpy as np
import pyvista
import SimpleITK
from vtkmodules.vtkIOImage import vtkNIFTIImageReader

print({name: version(name) for name in ("nibabel", "simpleitk", "vtk", "pyvista")})
spacing, corner = np.array([10., 20., 30.]), np.array([-100., 200., 300.])
affine = np.diag([*spacing, 1.])
affine[:3, 3] = corner
data = np.zeros((4, 5, 6), np.uint8)
data[1:3, 1:4, 2:4] = 1


def by_nibabel(name):
    image = nibabel.load(name)
    center = image.affine @ [*np.argwhere(np.asarray(image.dataobj) == 1).mean(axis=0), 1]
    return np.prod(nibabel.affines.voxel_sizes(image.affine)), center[:3]


def by_simpleitk(name):
    image = SimpleITK.ReadImage(name)
    shapes = SimpleITK.LabelShapeStatisticsImageFilter()
    shapes.Execute(image)
    return np.prod(image.GetSpacing()), np.array(shapes.GetCentroid(1)) * [-1, -1, 1]  # its x and y point the other way


def by_pyvista(name):
    return np.prod(pyvista.read(name).spacing)


def by_vtk(name):
    reader = vtkNIFTIImageReader()
    reader.SetFileName(name)
    reader.Update()
    return np.prod(reader.GetOutput().GetSpacing())


changed = False
for unit, millimeters in (("mm", 1), ("micron", 1e-3), ("meter", 1e3)):
    image = nibabel.Nifti1Image(data, affine)
    image.header.set_xyzt_units(unit, "sec")
    image.set_sform(affine, 1)
    image.set_qform(affine, 1)
    nibabel.save(image, "a.nii")
    assert nibabel.load("a.nii").header.get_xyzt_units()[0] == unit
    SimpleITK.WriteImage(SimpleITK.ReadImage("a.nii"), "again.nii")
    (volume, center), (right, right_center), (_, again) = by_nibabel("a.nii"), by_simpleitk("a.nii"), by_nibabel("again.nii")
    others = by_vtk("a.nii"), by_pyvista("a.nii")
    same = np.allclose(right, 6000 * millimeters ** 3) and np.allclose((volume, *others), 6000) and \
        np.allclose(right_center, center * millimeters, rtol=1e-4) and np.allclose(again, center * millimeters, rtol=1e-4)
    changed |= not same
    print(f"{unit}: volume of a voxel, SimpleITK {right:.3g} mm3, NiBabel {volume:.5g}, VTK {others[0]:.5g}, PyVista {others[1]:.5g}; "
          f"center of the mask by NiBabel {center.round(4).tolist()}, after SimpleITK wrote it {again.round(4).tolist()}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
