#!/usr/bin/env bash
# VTK 9.7 turns MetaImage files of SimpleITK the wrong way, and loses the axes of NIfTI and NRRD files.
#
# Surprise: an image whose axes are turned by 0.5 radian about z, with one bright voxel. SimpleITK writes it as .mha, .nrrd and
#   .nii, and reads it back at its place. PyVista takes the rotation of the .mha, but turns the other way: it reads rows of the
#   matrix for columns. Its own writer does the same, so a file that only VTK touches comes back right, and SimpleITK turns that
#   one the wrong way. The .nii comes without origin and axes. The .nrrd loses an axis: (6, 5, 4) voxels become (5, 4, 1), which
#   hold tuples of 6. Surfaces and cells from such an image lie elsewhere than the patient or the sample. SimpleITK itself drops
#   the axes in a legacy .vtk.
# Versions: VTK 9.7.2, PyVista 0.49.1, SimpleITK 2.5.7, nibabel 5.4.2, pynrrd 1.1.3
# Seen: 2026-11
# Do: read by SimpleITK, make the vtkImageData from its array, and set the direction matrix as GetDirection() returns it.
# Source: MetaIO manual, tag TransformMatrix, where each row is the direction of one axis of the image. NRRD definition, "space
#   directions", one vector for each axis. NIfTI-1, methods 2 and 3. VTK class reference, vtkImageData::SetDirectionMatrix, where
#   the columns are the axes.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet vtk==9.7.2 pyvista==0.49.1 SimpleITK==2.5.7 nibabel==5.4.2 pynrrd==1.1.3 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import nibabel
import nrrd
import numpy as np
import pyvista
import SimpleITK
import vtk

print({name: version(name) for name in ("vtk", "pyvista", "SimpleITK", "nibabel", "pynrrd")})
cos, sin = np.cos(.5), np.sin(.5)
voxel, origin, spacing = (5, 4, 3), np.array([10., 20, 30]), np.array([1., 2, 3])
turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])  # its columns are the axes
image = SimpleITK.GetImageFromArray(np.zeros((4, 5, 6), np.float32))
image.SetDirection(turn.ravel())
image.SetOrigin(origin)
image.SetSpacing(spacing)
image[voxel] = 1
for kind in ("mha", "nrrd", "nii", "vtk"):
    SimpleITK.WriteImage(image, "image." + kind)


def by_simpleitk(name):
    read = SimpleITK.ReadImage(name)
    bright = np.unravel_index(SimpleITK.GetArrayFromImage(read).argmax(), (4, 5, 6))
    return read.TransformIndexToPhysicalPoint([int(i) for i in bright[::-1]])


def by_pyvista(name):
    read = pyvista.read(name)
    if read.dimensions != (6, 5, 4):
        return f"{read.dimensions} voxels of {read.active_scalars.shape[1]} numbers"
    return read.points[read.active_scalars.argmax()]


def by_another(name):
    if name.endswith("nii"):
        return nibabel.affines.apply_affine(nibabel.load(name).affine, voxel) * [-1, -1, 1]  # right, anterior: the opposite
    if name.endswith("nrrd"):
        header = nrrd.read_header(name)
        return header["space origin"] + voxel @ header["space directions"]
    return None


right = origin + turn @ (spacing * voxel)
wrong = origin + turn.T @ (spacing * voxel)
flat = origin + spacing * voxel
copy = vtk.vtkMetaImageWriter()
copy.SetFileName("copy.mha")
copy.SetInputData(pyvista.read("image.mha"))
copy.Write()
own = pyvista.ImageData(dimensions=(6, 5, 4), spacing=spacing, origin=origin, direction_matrix=turn)
own["values"] = SimpleITK.GetArrayFromImage(image).ravel()
copy.SetFileName("own.mha")
copy.SetInputData(own)
copy.Write()
changed = False
print("the bright voxel is at", right.round(2))
for name, in_simpleitk, in_pyvista in (
        ("image.mha", right, wrong), ("own.mha", wrong, right), ("copy.mha", right, wrong), ("image.nii", right, flat - origin),
        ("image.nrrd", right, "(5, 4, 1) voxels of 6 numbers"), ("image.vtk", flat, flat)):
    for reader, read, stated in (("SimpleITK", by_simpleitk, in_simpleitk), ("PyVista", by_pyvista, in_pyvista),
                                 ("another", by_another, right)):
        seen = read(name)
        if seen is None:
            continue
        same = seen == stated if isinstance(stated, str) else not isinstance(seen, str) and np.allclose(seen, stated, atol=1e-5)
        changed |= not same
        print(f"{name} by {reader}:", seen if isinstance(seen, str) else np.round(seen, 2), "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
