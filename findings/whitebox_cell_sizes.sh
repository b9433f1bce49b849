#!/usr/bin/env bash
# Whitebox measures distances in rasters as if their cells were squares: a third of the cells gets another region than the nearest.
#
# Surprise: GeoTIFF states the width and the height of cells, and they need not agree. Whitebox takes the mean of both for each.
#   With cells of 10 by 30 meters a step along either axis counts 20 meters. Nearly all distances are wrong, by up to 570 meters,
#   and euclidean_allocation gives more than a third of the cells to a source that is not the nearest. SciPy and xarray-spatial
#   agree with a search among all sources. Nothing warns. With square cells 0.1 percent are wrong, by up to 3.5 cells.
# Versions: whitebox-workflows 2.0.6, xarray-spatial 0.5.3, SciPy 1.17.1, rasterio 1.4.4
# Seen: 2026-11
# Do: resample to square cells first, or take scipy.ndimage.distance_transform_edt with sampling=(height, width).
# Source: Whitebox Workflows manual, euclidean_distance ("true Euclidean distances", "in the same units as the horizontal units of
#   the input image") and euclidean_allocation ("essentially creates the Voronoi diagram"). GeoTIFF 1.1, ModelPixelScaleTag.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet whitebox-workflows==2.0.6 xarray-spatial==0.5.3 rasterio==1.4.4 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import os
import sys
from importlib.metadata import version

import numpy as np
import rasterio
import xarray
from rasterio.transform import from_origin
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree
from whitebox_workflows import WbEnvironment
from xrspatial import proximity

print({name: version(name) for name in ("whitebox-workflows", "xarray-spatial", "scipy", "rasterio")})
environment = WbEnvironment()
n, count = 300, 60
places = np.random.default_rng(1).choice(n * n, count, replace=False)
sources = np.zeros((n, n), np.float32)
sources.flat[places] = np.arange(1, count + 1)
rows, columns = np.divmod(np.arange(n * n), n)
changed = False
for width, height, stated, farthest in ((10, 10, 0, 35), (10, 30, .38, 570), (30, 10, .38, 570)):
    with rasterio.open("sources.tif", "w", driver="GTiff", height=n, width=n, count=1, dtype="float32", crs="EPSG:32632", nodata=-32768,
                       transform=from_origin(5e5, 5.2e6, width, height)) as file:
        file.write(sources, 1)
    raster = environment.read_raster(os.path.abspath("sources.tif"))
    results = {}
    for name in ("euclidean_distance", "euclidean_allocation"):
        getattr(environment.raster.distance_cost, name)(input=raster, output=os.path.abspath(f"{name}.tif"))
        with rasterio.open(f"{name}.tif") as file:
            results[name] = file.read(1).ravel()
    points = np.c_[width * columns, height * rows]
    right = cKDTree(points[places]).query(points)[0]
    to_own = np.linalg.norm(points - points[places[results["euclidean_allocation"].astype(int) - 1]], axis=1)
    by_scipy = distance_transform_edt(sources == 0, sampling=(height, width)).ravel()
    by_xarray = proximity(xarray.DataArray(sources, dims=("y", "x"), coords={"y": -height * np.arange(n, dtype=float),
                                                                            "x": width * np.arange(n, dtype=float)})).values.ravel()
    off = abs(results["euclidean_distance"] - right)
    wrong = np.mean(to_own > right + .1)
    same = abs(by_scipy - right).max() < 1e-6 and np.mean(abs(by_xarray - right) > .1) < 1e-3 and \
        (wrong < .01 and off.mean() < .1 if width == height else abs(wrong - stated) < .05 and np.mean(off > .1) > .95) and \
        abs(off.max() / farthest - 1) < .1
    changed |= not same
    print(f"cells of {width} by {height} m: distances wrong {np.mean(off > .1):.2%}, by up to {off.max():.0f} m; cells given to another source than "
          f"the nearest {wrong:.2%}; off by SciPy {abs(by_scipy - right).max():.1e}, xarray-spatial {np.mean(abs(by_xarray - right) > .1):.3%}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
