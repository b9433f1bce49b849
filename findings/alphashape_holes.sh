#!/usr/bin/env bash
# alphashape fills the holes of a shape in the plane.
#
# Surprise: 3500 points in a ring of radii 0.5 and 1, whose area is 2.356. alphashape returns a disc of area 3.08, without a hole,
#   for any alpha. It makes polygons from all border edges, those around a hole too, and unites them. The union of SciPy's
#   Delaunay triangles of circumradius below 1/alpha, by which both packages define the shape, is a ring of 2.26, and so is
#   the one of libpysal. In 3D alphashape keeps the hole of a hollow ball. Areas of ponds, cell layers and plumes are too large.
# Versions: alphashape 1.3.1, libpysal 4.14.1, SciPy 1.17.1, Shapely 2.2.0
# Seen: 2026-11
# Do: libpysal.cg.alpha_shape, or unite the triangles of scipy.spatial.Delaunay by shapely.union_all.
# Source: Edelsbrunner, Kirkpatrick, Seidel (1983), "On the shape of a set of points in the plane": alpha shapes may have holes.
#   alphashape's manual speaks of "the alpha shape (concave hull)".
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet alphashape==1.3.1 libpysal==4.14.1 scipy==1.17.1 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import alphashape
import numpy as np
import shapely
from libpysal.cg import alpha_shape
from scipy.spatial import Delaunay

print({name: version(name) for name in ("alphashape", "libpysal", "scipy", "shapely")})
points = np.random.default_rng(1).random((6000, 2)) * 2 - 1
points = points[abs(np.hypot(*points.T) - .75) < .25]
triangles = points[Delaunay(points).simplices]
sides = np.linalg.norm(triangles - np.roll(triangles, 1, axis=1), axis=2).prod(axis=1)
areas = shapely.area(shapely.polygons(triangles))
changed = False
for alpha in (5, 10, 15):
    by_scipy = shapely.union_all(shapely.polygons(triangles[sides / (4 * areas) < 1 / alpha]))
    by_libpysal = alpha_shape(points, alpha).union_all()
    made = alphashape.alphashape(points, alpha)
    filled = shapely.union_all([shapely.Polygon(part.exterior) for part in shapely.get_parts(by_scipy)])
    same = abs(by_libpysal.area - by_scipy.area) < 1e-9 and abs(made.area - filled.area) < 1e-9 and \
        made.area > by_scipy.area + .7
    changed |= not same
    print(f"{len(points)} points, alpha {alpha}: alphashape {made.area:.3f}, libpysal {by_libpysal.area:.3f}, SciPy "
          f"{by_scipy.area:.3f}, with its holes filled {filled.area:.3f}; the ring {np.pi * .75:.3f}", "" if same else "CHANGED")
ball = np.random.default_rng(1).random((8000, 3)) * 2 - 1
ball = ball[abs(np.linalg.norm(ball, axis=1) - .8) < .2]
share = alphashape.alphashape(ball, 4).volume / (4 / 3 * np.pi)
same = .6 < share < .784
changed |= not same
print(f"hollow ball: {share:.3f} of the ball, right is {1 - .6 ** 3:.3f}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
