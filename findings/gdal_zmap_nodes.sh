#!/usr/bin/env bash
# GDAL takes the nodes of a ZMAP grid for pixels: the surfaces of xtgeo and zmapio are squeezed, and those of GDAL are widened.
#
# Surprise: the header of a ZMAP+ grid states the places of the first and last nodes. GDAL takes them for the outer edges of pixels.
#   A surface of 41 by 31 nodes at 25 m comes with 24.39 by 24.19 m, and its border is 12 m off. Heights of wells, blocks and cells
#   come from other places. The other way, a raster that GDAL writes is read by xtgeo and zmapio with nodes 12.5 m outside of its
#   pixels; with northings in millions, limits are also rounded to whole meters. Nothing warns. zmapio has an option of nearly
#   the same name, pixel_is_point, which does the opposite: with it zmapio squeezes as GDAL does without its own.
# Versions: rasterio 1.4.4 with GDAL 3.10.3, xtgeo 4.27.0, zmapio 0.8.1
# Seen: 2026-12
# Do: set ZMAP_PIXEL_IS_POINT=YES for GDAL, also for writing, and leave pixel_is_point of zmapio at False; then all agree.
# Source: gdal.org/drivers/raster/zmap.html (pixels are areas by default, points by that option). xtgeo 4.27 manual, RegularSurface:
#   xori and yori are the place of the first node. zmapio 0.8.1, zmapio/zmap.py, pixel_is_point.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet rasterio==1.4.4 xtgeo==4.27.0 zmapio==0.8.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import rasterio
import rasterio.shutil
import xtgeo
import zmapio

print({name: version(name) for name in ("rasterio", "xtgeo", "zmapio")}, "GDAL", rasterio.__gdal_version__)
columns, rows, step = 41, 31, 25.
west, south = 460_000., 5_900_000.
limits = np.array([west, west + (columns - 1) * step, south, south + (rows - 1) * step])
x, y = np.meshgrid(west + step * np.arange(columns), south + step * np.arange(rows), indexing="ij")
surface = xtgeo.RegularSurface(ncol=columns, nrow=rows, xori=west, yori=south, xinc=step, yinc=step, values=1500 + (x - west) / 10)
surface.to_file("xtgeo.dat", fformat="zmap_ascii")
with rasterio.open("raster.tif", "w", driver="GTiff", width=columns, height=rows, count=1, dtype="float64",
                   transform=rasterio.transform.from_origin(west - step / 2, limits[3] + step / 2, step, step)) as raster:
    raster.write(np.flipud(surface.values.filled().T), 1)


def by_gdal(name):
    """Returns the first and last places of values: the middles of pixels."""
    with rasterio.open(name) as raster:
        (x0, y1), (x1, y0) = raster.xy(0, 0), raster.xy(raster.height - 1, raster.width - 1)
        return x0, x1, y0, y1


def by_xtgeo(name):
    grid = xtgeo.surface_from_file(name, fformat="zmap_ascii")
    return grid.xori, grid.xori + (grid.ncol - 1) * grid.xinc, grid.yori, grid.yori + (grid.nrow - 1) * grid.yinc


def by_zmapio(name, point_of_zmapio=False):
    table = zmapio.ZMAPGrid(name, pixel_is_point=point_of_zmapio).to_dataframe()
    return table.X.min(), table.X.max(), table.Y.min(), table.Y.max()


def by_zmapio_as_point(name):
    return by_zmapio(name, True)


changed = False
squeezed = 12.195, -12.195, 12.097, -12.097
for point, inward, outward in (("NO", squeezed, (-12.5, 12.5, -12, 12)), ("YES", 0, 0)):
    with rasterio.Env(ZMAP_PIXEL_IS_POINT=point):
        rasterio.shutil.copy("raster.tif", "gdal.dat", driver="ZMap")
        for way, reader, name, stated in (("raster.tif, GDAL", by_gdal, "raster.tif", 0),
                                          ("xtgeo's, xtgeo", by_xtgeo, "xtgeo.dat", 0),
                                          ("xtgeo's, zmapio", by_zmapio, "xtgeo.dat", 0),
                                          ("xtgeo's, zmapio as point", by_zmapio_as_point, "xtgeo.dat", squeezed),
                                          ("xtgeo's, GDAL", by_gdal, "xtgeo.dat", inward),
                                          ("GDAL's, xtgeo", by_xtgeo, "gdal.dat", outward),
                                          ("GDAL's, zmapio", by_zmapio, "gdal.dat", outward)):
            off = np.array(reader(name)) - limits
            same = np.allclose(off, stated, rtol=0, atol=.002)
            changed |= not same
            print(f"ZMAP_PIXEL_IS_POINT={point}, {way:24} off by {np.round(off, 3).tolist()} m in west, east, south, north",
                  "" if same else f"CHANGED, was {stated}")
sys.exit(bool(changed))
EOF
