#!/usr/bin/env bash
# omfvista turns the origin of a block model with its axes: the model of a mine lies up to thousands of kilometers from its points.
#
# Surprise: a block model in OMF states its origin and the directions of its axes. omfvista adds the origin first and then turns the
#   sum, so the origin turns about zero. Near zero nobody notices. In coordinates of UTM a model turned by 1 degree lies 103
#   kilometers away, by 30 degrees 3063. Points of the same file, here the corners of the model, stay where they are. The same holds for
#   grids of surfaces, and for discretize, which reads the origin right and then turns it in to_vtk(). Volumes are right, and
#   nothing warns. Models along the axes are right.
# Versions: omfvista 0.3.1, omf 1.0.1, discretize 0.12.0, PyVista 0.49.1
# Seen: 2026-11
# Do: move the result by origin - origin @ [axis_u, axis_v, axis_w].
# Source: omf documentation, VolumeGridGeometry and SurfaceGridGeometry: "origin: Origin of the Mesh relative to origin of the Project",
#   "axis_u: Vector orientation of u-direction". omfvista documentation, load_project.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet omfvista==0.3.1 omf==1.0.1 discretize==0.12.0 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import discretize
import numpy as np
import omf
import omfvista
import pyvista

print({name: version(name) for name in ("omfvista", "omf", "discretize", "pyvista")})


def center(mesh):
    return np.reshape(mesh.bounds, (3, 2)).mean(axis=1)


changed = False
on_map = 460_000, 5_900_000, 200
for origin, turn, stated in (((0, 0, 0), 30, 0), (on_map, 0, 0), ((500, 800, 200), 30, 488.3), (on_map, 1, 103_286), (on_map, 30, 3_063_333)):
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    axes = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    named = dict(zip(("axis_u", "axis_v", "axis_w"), axes))
    sizes = np.full(30, 10.), np.full(20, 10.), np.full(8, 5.)
    corners = np.array([[i, j, k] for i in (0, 300) for j in (0, 200) for k in (0, 40)]) @ axes + origin
    project = omf.Project(name="mine", author="", revision="1", description="", origin=(0, 0, 0))
    project.elements = [
        omf.PointSetElement(name="corners", geometry=omf.PointSetGeometry(vertices=corners)),
        omf.VolumeElement(name="blocks", data=[omf.ScalarData(name="grade", location="cells", array=np.arange(4800.))],
                          geometry=omf.VolumeGridGeometry(tensor_u=sizes[0], tensor_v=sizes[1], tensor_w=sizes[2], origin=origin, **named)),
        omf.SurfaceElement(name="floor", geometry=omf.SurfaceGridGeometry(
            tensor_u=sizes[0], tensor_v=sizes[1], offset_w=np.zeros(31 * 21), origin=origin, axis_u=axes[0], axis_v=axes[1]))]
    omf.OMFWriter(project, "mine.omf")
    blocks = omfvista.load_project("mine.omf")
    points, volume, floor = (blocks[name] for name in ("corners", "blocks", "floor"))
    mesh = discretize.TensorMesh.from_omf(omf.OMFReader("mine.omf").get_project().elements[1])[0]
    by_discretize = pyvista.wrap(mesh.to_vtk())
    right = center(points)
    away = [np.linalg.norm(center(each) - right) for each in (volume, by_discretize)]
    away.append(np.linalg.norm(center(floor)[:2] - right[:2]))
    shift = origin - origin @ axes
    mended = max(np.linalg.norm(center(each) + shift - right) for each in (volume, by_discretize))
    same = np.allclose(away, stated, rtol=1e-3, atol=.01) and np.allclose(mesh.origin, origin) and mended < .01 and \
        abs(volume.volume / 2.4e6 - 1) < 1e-6
    changed |= not same
    print(f"origin {origin}, turned by {turn} degrees: blocks away from the points of their corners by omfvista {away[0]:.1f} m, by discretize "
          f"{away[1]:.1f}, floor {away[2]:.1f}; volume {volume.volume:.6g}; moved back {mended:.1e}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
