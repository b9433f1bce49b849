#!/usr/bin/env bash
# VTK's Delaunay filters leave out simplices at the convex hull.
#
# Surprise: of 1000 random points in a cube, PyVista's delaunay_3d() returns 6135 of the 6263 tetrahedra. They fill 98.1 % of
#   the hull; in a square delaunay_2d() returns 1956 of 1979 triangles. All that are returned are right ones. The filters begin with
#   a simplex of finite size around the points and remove whatever touches it, so points of the hull keep dents; offset is a
#   multiple of the size. SciPy fills the hull. Volumes, interpolation and meshes from PyVista have holes at the border, and nothing
#   is printed. With offset=1e5 all are there.
# Versions: PyVista 0.49.1, VTK 9.7.2, SciPy 1.17.1
# Seen: 2026-11
# Do: scipy.spatial.Delaunay, or a large offset such as 1e5, and compare the volume with scipy.spatial.ConvexHull(points).volume.
# Source: PyVista manual, delaunay_3d ("construct a 3D Delaunay triangulation"; offset sizes the initial bounding
#   triangulation); Qhull manual, "qdelaun" (the Delaunay triangulation fills the convex hull).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyvista==0.49.1 vtk==9.7.2 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import pyvista
from scipy.spatial import ConvexHull, Delaunay

print({name: version(name) for name in ("pyvista", "vtk", "scipy")})
changed = False
for dimensions, offset, stated in ((3, 2.5, 6135), (3, 1e5, 6263), (2, 1, 1956), (2, 1e5, 1979)):
    random = np.random.default_rng(dimensions)
    points = random.random((1000, dimensions))
    cloud = pyvista.PolyData(np.c_[points, np.zeros((1000, 3 - dimensions))])
    found = cloud.delaunay_3d(offset=offset) if dimensions == 3 else cloud.delaunay_2d(offset=offset)
    size = found.volume if dimensions == 3 else found.area
    rows = found.cells.reshape(-1, 5)[:, 1:] if dimensions == 3 else found.regular_faces
    right = set(map(tuple, np.sort(Delaunay(points).simplices).tolist()))
    seen = set(map(tuple, np.sort(rows).tolist()))
    share = size / ConvexHull(points).volume
    same = len(seen) == stated and seen <= right
    changed |= not same
    print(f"{dimensions}D, offset {offset:g}: VTK {len(seen)} simplices, SciPy {len(right)}, {len(seen & right)} in both; "
          f"VTK's fill {share:.4%} of the hull", "" if same else "CHANGED")
sys.exit(changed)
EOF
