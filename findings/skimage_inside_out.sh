#!/usr/bin/env bash
# Surfaces of scikit-image are inside out: trimesh finds a negative volume, Manifold adds a hole, PyVista swaps inside and outside.
#
# Surprise: marching_cubes() of a dense object in a thin background returns triangles that run clockwise when seen from outside. Its
#   default, "descent", is meant for such objects, but for the left-hand rule; every other library here takes the right hand. The vertex
#   normals of the same call point outward, against the triangles. A ball of 2125 voxels has -2125 in trimesh and Manifold, though it
#   is watertight. Taken from a box of 38760 it leaves 40885. In PyVista the ball's center is outside and a far corner inside,
#   and distances have the other sign. PyMCubes and PyVista's contour() return the same surface the right way out. Nothing warns.
# Versions: scikit-image 0.26.0, PyMCubes 0.1.6, trimesh 5.2.0, Manifold 3.5.4, PyVista 0.49.1, VTK 9.7.2
# Seen: 2026-12
# Do: faces[:, ::-1], or gradient_direction="ascent" for objects that are denser than the background.
# Source: scikit-image 0.26 manual, measure.marching_cubes, gradient_direction ("considering the left-hand rule", "descent: Object was
#   greater than exterior"). Manifold manual, MeshGL: triVerts counter-clockwise from the outside.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet scikit-image==0.26.0 pymcubes==0.1.6 trimesh==5.2.0 manifold3d==3.5.4 pyvista==0.49.1 vtk==9.7.2 \
    numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import manifold3d
import mcubes
import numpy as np
import pyvista
import trimesh
from skimage.measure import marching_cubes

print({name: version(name) for name in ("scikit-image", "pymcubes", "trimesh", "manifold3d", "pyvista")})
size, center, radius = (30, 34, 38), np.array([12., 15., 20.]), 8
places = np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), axis=-1)
density = radius - np.linalg.norm(places - center, axis=-1)
image = pyvista.ImageData(dimensions=size)
image["density"] = density.ravel(order="F")
contour = image.contour([0.], scalars="density")
box = manifold3d.Manifold.cube(size)
two = pyvista.PolyData(np.array([center, (1, 1, 1)]))
changed = False
for name, (vertices, faces, *rest), sign in (("scikit-image", marching_cubes(density, 0), -1),
                                             ("scikit-image, ascent", marching_cubes(density, 0, gradient_direction="ascent"), 1),
                                             ("PyMCubes", mcubes.marching_cubes(density, 0), 1),
                                             ("PyVista", (contour.points, contour.regular_faces), 1)):
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    ball = manifold3d.Manifold(manifold3d.Mesh(vertices.astype(np.float32), faces.astype(np.uint32)))
    rest_of_box = (box - ball).volume()
    surface = pyvista.PolyData.from_regular_faces(vertices, faces)
    inside = two.select_interior_points(surface)["selected_points"].astype(bool).tolist()
    distance = two.compute_implicit_distance(surface)["implicit_distance"]
    outward = ((vertices - center) * rest[0]).sum(axis=1).min() > 0 if rest else None
    same = mesh.is_watertight and np.allclose((mesh.volume, ball.volume(), 38760 - rest_of_box), sign * 2124.75, atol=1) and \
        inside == [sign > 0, sign < 0] and np.array_equal(np.sign(distance), [-sign, sign]) and outward in (None, True)
    changed |= not same
    print(f"{name}: volume {mesh.volume:.1f} by trimesh, {ball.volume():.1f} by Manifold; box without ball {rest_of_box:.1f} of 38760; PyVista: "
          f"center inside {inside[0]}, corner inside {inside[1]}, distances {np.round(distance, 2).tolist()}; normals outward {outward}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
