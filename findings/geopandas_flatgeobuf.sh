#!/usr/bin/env bash
# Rows of a FlatGeobuf file that GeoPandas wrote come back in another order.
#
# Surprise: the Voronoi cells of 200 seeds, one row for each, are written with to_file("cells.fgb") and read back. 199 rows
#   are elsewhere, under a fresh index 0 to 199. An array of the seeds' values, which fits the table that was written, now
#   belongs to other cells: only as long as it was a column of the file does it move along. GDAL sorts the features along a
#   curve for its spatial index. GeoPackage, GeoJSON, shapefile and Parquet keep the order.
# Versions: GeoPandas 1.2.0, pyogrio 0.13.0 (its GDAL), Shapely 2.2.0
# Seen: 2026-11
# Do: write a column with the number of the row and sort by it, or pass SPATIAL_INDEX="NO" to to_file.
# Source: GDAL manual, FlatGeobuf driver, layer creation option SPATIAL_INDEX (YES by default). FlatGeobuf's
#   specification: an indexed file has its features along a Hilbert curve. GeoPandas manual, to_file, which names neither.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet geopandas==1.2.0 pyogrio==0.13.0 shapely==2.2.0 pyarrow numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import geopandas
import numpy as np
import pyogrio
import shapely

print({name: version(name) for name in ("geopandas", "pyogrio", "shapely")}, "GDAL", pyogrio.__gdal_version__)
seeds = np.random.default_rng(1).random((200, 2)) * 1000
cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(seeds), ordered=True))
written = geopandas.GeoDataFrame({"row": range(200)}, geometry=cells, crs=32632)
changed = False
for name, options, kept in (("fgb", {}, 1), ("fgb", {"SPATIAL_INDEX": "NO"}, 200), ("gpkg", {}, 200), ("geojson", {}, 200),
                            ("shp", {}, 200), ("parquet", {}, 200)):
    if name == "parquet":
        written.to_parquet("cells.parquet")
        table = geopandas.read_parquet("cells.parquet")
    else:
        written.to_file(f"cells.{name}", **options)
        table = geopandas.read_file(f"cells.{name}")
    places = int((table.row == written.row).sum())
    around = int(shapely.contains(table.geometry.to_numpy(), shapely.points(seeds)).sum())
    same = places == kept and list(table.index) == list(range(200)) and sorted(table.row) == list(range(200)) and \
        (around == 200) == (kept == 200)
    changed |= not same
    print(f".{name} {options}: {places} of 200 rows at their places; {around} cells hold the seed of their row",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
