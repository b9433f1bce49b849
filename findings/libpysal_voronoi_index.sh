#!/usr/bin/env bash
# libpysal's voronoi_frames loses the labels of GeoPandas, and after a filter the cells of other points, or none at all.
#
# Surprise: the manual promises an index that links cells to the input. For points labeled from 100 on, a GeoSeries gives cells
#   labeled from 0, and a GeoDataFrame an empty table. For labels in another order the series and the frame give different
#   answers. After a filter that keeps every second of 50 points the series has the labels 0 to 24, and the frame 13 cells.
#   GeoPandas joins by labels, and so gives values to wrong cells. Nothing is raised. Labels 0, 1, 2, ... work, as all examples
#   have them.
# Versions: libpysal 4.14.1, GeoPandas 1.2.0, Shapely 2.2.0
# Seen: 2026-11
# Do: points.reset_index(drop=True) before voronoi_frames, and join by position.
# Source: libpysal manual, voronoi_frames, Returns ("Voronoi polygons with index allowing to link back to the input").
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet libpysal==4.14.1 geopandas==1.2.0 shapely==2.2.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import geopandas
import numpy as np
import shapely
from libpysal.cg import voronoi_frames

print({name: version(name) for name in ("libpysal", "geopandas", "shapely")})
rng = np.random.default_rng(0)
places = shapely.points(rng.random((50, 2)) * 1000)
every_second = geopandas.GeoSeries(places)[::2]
trials = {
    "labels 0, 1, ...": (geopandas.GeoSeries(places), (50, 1, 50, 1)),
    "labels 100, 101, ...": (geopandas.GeoSeries(places, index=np.arange(100, 150)), (50, 0, 0, None)),
    "shuffled labels": (geopandas.GeoSeries(places, index=rng.permutation(50)), (50, 0.02, 50, 1)),
    "every second point": (every_second, (25, 0.04, 13, 0.08)),
}


def share(cells, points):
    """Returns how many cells hold the point of their label."""
    if len(cells) == 0:
        return None
    own = points.reindex(cells.index)
    return round(np.mean([p is not None and c.intersects(p) for c, p in zip(cells.geometry, own)]), 2)


changed = False
for name, (points, stated) in trials.items():
    series = voronoi_frames(points, return_input=False)
    frame = voronoi_frames(geopandas.GeoDataFrame({"value": range(len(points))}, geometry=points), return_input=False)
    seen = len(series), share(series, points), len(frame), share(frame, points)
    changed |= seen != stated
    print(f"{name}: {len(points)} points; of a GeoSeries {seen[0]} cells, {seen[1]:.0%} with their own label; of a GeoDataFrame "
          f"{seen[2]} cells" + ("" if seen[3] is None else f", {seen[3]:.0%} with their own label"),
          "" if seen == stated else "CHANGED")
sys.exit(changed)
EOF
