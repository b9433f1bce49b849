#!/usr/bin/env bash
# Voronoi cells of xugrid come in another order than the nodes of its mesh: as many of them, with values of other nodes.
#
# Surprise: tesselate_centroidal_voronoi() and tesselate_circumcenter_voronoi() return a grid with one face for each node. The
#   faces of inner nodes come first, those of border nodes last, whatever the order of the nodes. Values at nodes fit into the new
#   grid by their number, so nothing warns, and 93 percent of the cells get the value of another node. Heights from 0 to 300 on a
#   plane are off by 73 on average. The order is not returned. With add_exterior=False border cells are left out, and the
#   faces are numbered over without them. Cells themselves are right: with circumcenters they have the areas of SciPy's Voronoi.
# Versions: xugrid 0.15.3, SciPy 1.17.1, Shapely 2.2.0
# Seen: 2026-12
# Do: find the node of each face: shapely.STRtree(cells).query(shapely.points(nodes), predicate="covered_by"), then sort the values.
# Source: xugrid manual 0.15, Ugrid2d.tesselate_centroidal_voronoi and tesselate_circumcenter_voronoi, "Create a ... Voronoi
#   tesselation of this UGRID2D topology"; neither states the order of the faces or how to find it.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet xugrid==0.15.3 scipy==1.17.1 shapely==2.2.0 xarray==2026.9.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import numpy as np
import shapely
import xarray
import xugrid
from scipy.spatial import Delaunay, Voronoi

print({name: version(name) for name in ("xugrid", "scipy", "shapely")})
rng = np.random.default_rng(1)
line = np.linspace(0, 100, 15)
nodes = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
nodes += rng.uniform(-2, 2, nodes.shape) * ((nodes > 0) & (nodes < 100))
inner = ((nodes > 0) & (nodes < 100)).all(axis=1)
heights = nodes @ [1, 2]
mesh = xugrid.Ugrid2d(*nodes.T, -1, Delaunay(nodes).simplices)
print(f"mesh of {len(nodes)} nodes, {inner.sum()} of them inside, area {mesh.area.sum():.1f}")
diagram = Voronoi(nodes)
changed = False
for name, tessellate in (("centroids", mesh.tesselate_centroidal_voronoi), ("circumcenters", mesh.tesselate_circumcenter_voronoi)):
    grid = tessellate()
    cells = grid.to_shapely(grid.face_dimension)
    by_number = xugrid.UgridDataArray(xarray.DataArray(heights, dims=[grid.face_dimension]), grid)   # taken without a word
    node, face = shapely.STRtree(cells).query(shapely.points(nodes), predicate="covered_by")
    matched = np.array_equal(node, np.arange(len(nodes))) and np.array_equal(np.sort(face), np.arange(len(cells)))
    other = np.mean(face != node)
    error = abs(by_number.values[face] - heights).mean()
    last = face[~inner].min() == inner.sum()
    by_node = np.empty(len(cells))
    by_node[face] = heights
    middles = shapely.get_coordinates(shapely.centroid(cells)) @ [1, 2]
    mended = abs(by_node - middles).mean()
    areas = shapely.area(cells)[face]
    own = [shapely.area(shapely.convex_hull(shapely.multipoints(diagram.vertices[diagram.regions[diagram.point_region[i]]])))
           for i in np.flatnonzero(inner)]
    as_scipy = np.mean(abs(areas[inner] / own - 1) < 1e-6)
    without = tessellate(add_exterior=False)
    same = matched and len(cells) == len(nodes) and last and abs(other - .93) < .02 and abs(error - 73.4) < 1 and mended < 2 and \
        abs(areas.sum() - 1e4) < 1 and (as_scipy > .9 if name == "circumcenters" else as_scipy < .1) and without.n_face < len(nodes)
    changed |= not same
    print(f"{name}: {len(cells)} cells, area {areas.sum():.1f}, {as_scipy:.1%} of the inner ones as SciPy's; {other:.1%} of the cells "
          f"have the number of another node, border cells last {last}; heights off by {error:.1f} on average, by nodes {mended:.1f}; "
          f"without the exterior {without.n_face} cells", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
