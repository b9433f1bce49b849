#!/usr/bin/env bash
# A cropped image moves by the crop, when ITK and VTK hand it to each other, and when VTK writes it as NIfTI.
#
# Surprise: in ITK and in VTK an image may start at another index than 0, and the origin is the place of index 0, not that of the
#   first voxel. PyVista's crop() and ITK's ExtractImageFilter return such images. itk.image_from_vtk_image and
#   itk.vtk_image_from_image copy the origin and lose the start. So do itk.xarray_from_image and vtkNIFTIImageWriter. The crop then
#   begins where the whole began: what is measured, meshed or tessellated in it lies elsewhere. Nothing warns.
#   Files of itk.imwrite and vtkMetaImageWriter are right.
# Versions: ITK 5.4.7, VTK 9.7.2, PyVista 0.49.1, SimpleITK 2.5.7
# Seen: 2026-12
# Do: in PyVista crop with extract_subset(), in ITK with RegionOfInterestImageFilter; both move the origin and start at 0. Or
#   add start * spacing to the origin of the result.
# Source: ITK Software Guide, section 4.1.4, Defining Origin and Spacing (the origin belongs to index 0). VTK 9.7 manual,
#   vtkImageData: TransformIndexToPhysicalPoint, SetExtent. ITK 5.4, docstrings of itk.support.extras, which name no limit.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet itk==5.4.7 vtk==9.7.2 pyvista==0.49.1 simpleitk==2.5.7 xarray==2026.9.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import itk
import numpy as np
import pyvista
import SimpleITK
import vtk

print({name: version(name) for name in ("itk", "vtk", "pyvista", "simpleitk")})
size, spacing, origin = (20, 16, 12), (.5, 1., 2.), (100., 200., 300.)
start, length = (5, 4, 3), (10, 8, 6)
bright = 8, 7, 5
values = np.zeros(size[::-1], np.float32)
values[bright[::-1]] = 1
right = np.array(origin) + np.array(bright) * spacing
moved = right - np.array(start) * spacing


def by_itk(image):
    """Returns the place of the bright voxel by ITK itself."""
    index = [int(i) for i in np.argwhere(itk.array_view_from_image(image))[0][::-1] + tuple(itk.region(image).GetIndex())]
    return np.array(image.TransformIndexToPhysicalPoint(index))


def by_vtk(image):
    image = pyvista.wrap(image)
    return image.points[np.argmax(image.active_scalars)]


def by_file(name):
    image = SimpleITK.ReadImage(name)
    index = np.argwhere(SimpleITK.GetArrayFromImage(image))[0][::-1].tolist()
    return np.array(image.TransformIndexToPhysicalPoint(index))


def by_xarray(array):
    k, j, i = np.argwhere(array.values)[0]
    return np.array([float(array.x[i]), float(array.y[j]), float(array.z[k])])


def written_by_vtk(writer, name, image):
    writer.SetInputData(image)
    writer.SetFileName(name)
    writer.Write()
    return by_file(name)


whole = pyvista.ImageData(dimensions=size, spacing=spacing, origin=origin)
whole["values"] = values.ravel()
crop = whole.crop(extent=[each for i, n in zip(start, length) for each in (i, i + n - 1)])
subset = whole.extract_subset([each for i, n in zip(start, length) for each in (i, i + n - 1)])

scan = itk.image_from_array(values)
scan.SetSpacing(spacing)
scan.SetOrigin(origin)
region = itk.ImageRegion[3]()
region.SetIndex(start)
region.SetSize(length)
part = itk.extract_image_filter(scan, extraction_region=region, direction_collapse_to_strategy=1)
roi = itk.region_of_interest_image_filter(scan, region_of_interest=region)
itk.imwrite(part, "part.mha")

nifti = written_by_vtk(vtk.vtkNIFTIImageWriter(), "crop.nii", crop)
nifti_subset = written_by_vtk(vtk.vtkNIFTIImageWriter(), "subset.nii", subset)
nifti_shift = (nifti - nifti_subset) * (-1, -1, 1)   # VTK states no orientation; readers turn x and y
ways = {
    "PyVista crop()": (by_vtk(crop), right),
    "  itk.image_from_vtk_image": (by_itk(itk.image_from_vtk_image(crop)), moved),
    "  vtkNIFTIImageWriter, beside extract_subset()": (right + nifti_shift, moved),
    "  vtkMetaImageWriter": (written_by_vtk(vtk.vtkMetaImageWriter(), "crop.mha", crop), right),
    "PyVista extract_subset(), itk.image_from_vtk_image": (by_itk(itk.image_from_vtk_image(subset)), right),
    "ITK ExtractImageFilter": (by_itk(part), right),
    "  itk.vtk_image_from_image": (by_vtk(itk.vtk_image_from_image(part)), moved),
    "  itk.xarray_from_image": (by_xarray(itk.xarray_from_image(part)), moved),
    "  itk.imwrite": (by_file("part.mha"), right),
    "ITK RegionOfInterestImageFilter, itk.vtk_image_from_image": (by_vtk(itk.vtk_image_from_image(roi)), right),
}
changed = False
for way, (place, stated) in ways.items():
    same = np.allclose(place, stated)
    changed |= not same
    print(f"{way:58} bright voxel at {place.tolist()}{'' if np.allclose(place, right) else f', not {right.tolist()}'}",
          "" if same else f"CHANGED, was {stated.tolist()}")
sys.exit(bool(changed))
EOF
