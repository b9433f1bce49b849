#!/usr/bin/env bash
# SciPy's Delaunay and Voronoi drop points, or join the wrong ones, where the coordinates are large: maps in meters, for example.
#
# Surprise: 1000 random points in a square of 10 m, in coordinates of UTM such as (500000, 4600000). SciPy's Delaunay drops 717
#   points as coplanar and returns 548 triangles, of which 45 are right. In 1 m it keeps
#   17 points; in 1 km 4 of 1982 triangles are wrong. In 1 m LinearNDInterpolator is off by half the range. Nothing is printed.
#   Doubles hold these coordinates to a billionth of a meter: Matplotlib and Shapely (GEOS) return all triangles, and so does
#   SciPy of points less their mean.
# Versions: SciPy 1.17.1, Matplotlib 3.11.2, Shapely 2.2.0
# Seen: 2026-11
# Do: subtract the mean of the points before Delaunay, Voronoi and the interpolators, or pass rescale=True to the latter. Check
#   that Delaunay.coplanar is empty.
# Source: SciPy manual, scipy.spatial.Delaunay, attribute coplanar ("not included in the triangulation due to numerical
#   precision issues"), without a word on the origin. Qhull manual, "Imprecision in Qhull": it squares the coordinates.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet scipy==1.17.1 matplotlib==3.11.2 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import shapely
from matplotlib.tri import Triangulation
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

print({name: version(name) for name in ("scipy", "matplotlib", "shapely")})


def rows(triangles):
    return set(map(tuple, np.sort(triangles).tolist()))


def by_shapely(points):
    ids = {tuple(p): i for i, p in enumerate(points.tolist())}
    return rows([[ids[p] for p in t.exterior.coords[:3]] for t in shapely.delaunay_triangles(shapely.MultiPoint(points)).geoms])


origin = np.array([500000, 4600000])
changed = False
# The size of the square, SciPy's triangles, the right ones among them, its dropped points, and the least
# error of an interpolated paraboloid of range 1.
for size, stated in ((1, (16, 0, 983, .1)), (10, (548, 45, 717, .005)), (1000, (1982, 1978, 0, 0)),
                     (10000, (1982, 1982, 0, 0))):
    points = origin + np.random.default_rng(1).random((1000, 2)) * size
    near = points - origin  # exact
    right, found = rows(Delaunay(near).simplices), Delaunay(points)
    triangles = rows(found.simplices)
    values = ((near / size - .5) ** 2).sum(axis=1) * 2
    places = (.2 + .6 * np.random.default_rng(2).random((1000, 2))) * size
    error = np.nanmax(abs(LinearNDInterpolator(points, values)(places + origin) - LinearNDInterpolator(near, values)(places)))
    seen = len(triangles), len(triangles & right), len(found.coplanar)
    same = seen == stated[:3] and error >= stated[3] and \
        rows(Triangulation(*points.T).triangles) == right and by_shapely(points) == right
    changed |= not same
    print(f"{size} m: SciPy {seen[0]} triangles, {seen[1]} right, {seen[2]} points dropped, interpolation off "
          f"by {error:.2g} of the range; Matplotlib and Shapely {len(right)}, all right", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
