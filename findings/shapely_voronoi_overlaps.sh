#!/usr/bin/env bash
# Voronoi cells of Shapely 2.2 (GEOS 3.14) overlap where points are regular and rounded: rotated lattices, outlines of buildings.
#
# Surprise: a lattice of 20 by 20 points, turned by 10 degrees. The cells of shapely.voronoi_polygons() sum to 17.6 times the
#   rectangle that they should tile, 179 of 400 are invalid polygons, and some do not hold their point. Shapely 2.1.2 with GEOS
#   3.13 returns right cells for the same points, and so does SciPy. GeoPandas, libpysal and momepy take Shapely's: momepy's
#   cells of 25 buildings, in rows and columns, sum to 159 % of the area. Delaunay triangles of Shapely are right, and so are
#   Voronoi cells of random points. Nothing is raised.
# Versions: Shapely 2.2.0 (GEOS 3.14.1) and 2.1.2 (GEOS 3.13.1), momepy 0.11.0, libpysal 4.14.1, SciPy 1.17.1
# Seen: 2026-11
# Do: compare the sum of areas with the area of the union, or take Shapely 2.1.2, or scipy.spatial.Voronoi.
# Source: Shapely manual, voronoi_polygons (a Voronoi diagram of the vertices). momepy manual, morphological_tessellation: cells
#   partition the space.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv old
old/bin/pip install --quiet shapely==2.1.2 numpy==2.4.6
"${PYTHON:-python3}" -m venv new
new/bin/pip install --quiet shapely==2.2.0 momepy==0.11.0 libpysal==4.14.1 geopandas==1.2.0 scipy==1.17.1 numpy==2.4.6

cat >lattice.py <<'END'
import numpy as np
import shapely

turn = np.radians(10)
lattice = np.stack(np.meshgrid(np.arange(20.0), np.arange(20.0)), -1).reshape(-1, 2)
points = lattice @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
cells = np.array(shapely.voronoi_polygons(shapely.MultiPoint(points)).geoms)
sum_of_areas = shapely.area(cells).sum() / shapely.box(*shapely.total_bounds(cells)).area
invalid = int((~shapely.is_valid(cells)).sum())
print(f"Shapely {shapely.__version__}, GEOS {shapely.geos_version_string}: {len(cells)} cells, sum of areas {sum_of_areas:.3f} of "
      f"their rectangle, {invalid} invalid", end=" ")
END

old/bin/python - <<'EOF'
import sys

from lattice import invalid, sum_of_areas

same = abs(sum_of_areas - 1) < 1e-9 and invalid == 0
print("" if same else "CHANGED")
sys.exit(not same)
EOF

new/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import geopandas
import momepy
import numpy as np
import shapely
from lattice import invalid, points, sum_of_areas
from scipy.spatial import Voronoi

changed = not (sum_of_areas > 10 and invalid > 100)
print("CHANGED" if changed else "")
voronoi = Voronoi(points)
regions = [voronoi.regions[k] for k in voronoi.point_region]
areas = np.array([shapely.MultiPoint(voronoi.vertices[r]).convex_hull.area for r in regions if -1 not in r])
inner = np.sort(areas)[:18 * 18]
same = np.allclose(inner, 1)
changed |= not same
print(f"SciPy: {np.isclose(areas, 1).sum()} cells of area 1", "" if same else "CHANGED")
triangles = shapely.delaunay_triangles(shapely.MultiPoint(points))
same = np.isclose(triangles.area, 19 * 19)
changed |= not same
print(f"Delaunay triangles of Shapely: {triangles.area:.6f} of 361", "" if same else "CHANGED")
buildings = geopandas.GeoSeries([shapely.box(60 * i, 120 * j, 60 * i + 20, 120 * j + 20 + 40 * ((i + 5 * j) % 3))
                                 for j in range(5) for i in range(5)])
clip = buildings.union_all().envelope.buffer(10)
cells = momepy.morphological_tessellation(buildings, clip=clip, simplify=False)
total = cells.area.sum() / clip.area
same = total > 1.2 and len(cells) == 25
changed |= not same
print({name: version(name) for name in ("momepy", "libpysal")}, f"{len(cells)} cells of buildings, sum of areas {total:.3f} of "
      "the whole", "" if same else "CHANGED")
sys.exit(changed)
EOF
