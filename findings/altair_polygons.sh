#!/usr/bin/env bash
# Altair paints everything except a polygon whose ring runs as GeoJSON prescribes.
#
# Surprise: a Voronoi cell on a map, written by GDAL with RFC7946=YES and read by GeoPandas, so that its ring runs
#   counterclockwise. mark_geoshape() paints the map outside of the cell, and twelve cells become one sheet of the last color.
#   The same cell clockwise, as shapely.voronoi_polygons makes it, is drawn right. Vega (d3-geo) takes a ring on
#   the sphere for the border of what lies to its right; GeoJSON says left. GeoPandas passes rings on as they are.
# Versions: Altair 6.3.0, vl-convert-python 1.9.0, GeoPandas 1.2.0, pyogrio 0.13.0, Shapely 2.2.0
# Seen: 2026-11
# Do: shapely.orient_polygons(cells, exterior_cw=True) before the chart, or project(type="identity", reflectY=True).
# Source: RFC 7946, section 3.1.6 (exterior rings are counterclockwise). Manual of d3-geo, which Vega draws by: it
#   wants the opposite order.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet altair==6.3.0 vl-convert-python==1.9.0.post1 geopandas==1.2.0 pyogrio==0.13.0 shapely==2.2.0 \
    pillow numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import io
import sys
from importlib.metadata import version

import altair
import geopandas
import numpy as np
import shapely
import vl_convert
from PIL import Image

print({name: version(name) for name in ("altair", "vl-convert-python", "geopandas", "pyogrio", "shapely")})
domain = shapely.box(-10, -10, 10, 10)
seeds = (np.random.default_rng(1).random((12, 2)) - .5) * 20
cells = shapely.intersection(shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(seeds), ordered=True)), domain)
cells = shapely.orient_polygons(cells, exterior_cw=True)
written = geopandas.GeoDataFrame({"seed": range(12)}, geometry=cells, crs=4326)
written.to_file("cells.json", driver="GeoJSON", RFC7946="YES")
read = geopandas.read_file("cells.json")


def painted(table, **projection):
    chart = altair.Chart(table).mark_geoshape(fill="#ff0000", stroke=None)
    chart = chart.project(**projection).properties(width=200, height=200, padding=0).configure_view(stroke=None)
    image = np.asarray(Image.open(io.BytesIO(vl_convert.vegalite_to_png(chart.to_dict()))).convert("RGB"))
    return float(np.mean((image[..., 0] > 200) & (image[..., 1] < 60)))


on_sphere = dict(type="equirectangular", scale=200 / np.radians(20), center=[0, 0], translate=[100, 100])
flat = dict(type="identity", reflectY=True, scale=10, translate=[100, 100])
changed = False
for row in (3, 7):
    share = cells[row].area / domain.area
    for name, table, right in (("clockwise", written, True), ("from GeoJSON", read, False)):
        cell = table[table.seed == row]
        ccw = bool(cell.geometry.exterior.is_ccw.iloc[0])
        found, plane = painted(cell, **on_sphere), painted(cell, **flat)
        same = ccw != right and abs(found - (share if right else 1 - share)) < .02 and abs(plane - share) < .02
        changed |= not same
        print(f"cell {row}, {share:.1%} of the map, {name}, counterclockwise {ccw}: {found:.1%} painted, {plane:.1%} by "
              "identity", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
