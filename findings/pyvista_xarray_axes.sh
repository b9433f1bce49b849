#!/usr/bin/env bash
# pyvista-xarray puts values at wrong points unless an array's dimensions come in the order z, y, x.
#
# Surprise: xarray names the dimensions, and their order means nothing: a transposed array is the same data. The accessor
#   da.pyvista.mesh(x="x", y="y", z="z") takes the names for the coordinates only, and flattens the values as stored. So of the
#   six orders of a field five are scrambled, among them x, y, z, the order of most simulations. A field that is linear becomes
#   rough, and the part of the box below its middle value has a volume of 6.3 for 12. The sizes agree, so nothing warns. Second,
#   latitudes that fall from north to south, as in much climate data, are kept so, though VTK needs rising coordinates: probes
#   inside the map find no cell and give 0.
# Versions: pyvista-xarray 0.1.8, PyVista 0.49.1, xarray 2026.9.0
# Seen: 2026-12
# Do: da.transpose("z", "y", "x").sortby(["z", "y", "x"]) before .pyvista.
# Source: xarray manual, "Terminology" (dimension names) and DataArray.transpose. pyvista-xarray manual, mesh(x, y, z). VTK
#   class reference, vtkRectilinearGrid (coordinates increase monotonically).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pyvista-xarray==0.1.8 pyvista==0.49.1 xarray==2026.9.0 vtk==9.7.2 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version
from itertools import permutations

import numpy as np
import pvxarray  # noqa: F401, registers the accessor
import xarray

print({name: version(name) for name in ("pyvista-xarray", "pyvista", "xarray", "vtk")})
axes = {"z": np.arange(5.), "y": np.arange(4.), "x": np.arange(3.)}
field = xarray.DataArray(np.add.outer(np.add.outer(100 * axes["z"], 10 * axes["y"]), axes["x"]), coords=axes, name="v")
changed = False


def misplaced(mesh):
    return np.mean(np.abs(mesh["v"] - mesh.points @ [1, 10, 100]) > 1e-9)


for order in permutations("xyz"):
    turned = field.transpose(*order)
    assert turned.sel(x=1, y=2, z=3) == 321 and (turned == field).all()
    mesh = turned.pyvista.mesh(x="x", y="y", z="z")
    share, half = misplaced(mesh), mesh.clip_scalar("v", value=216, invert=True).volume
    same = (share == 0 and abs(half - 12) < 1e-6) if order == ("z", "y", "x") else share > .5
    changed |= not same
    print("order", *order, f"values at wrong points {share:.0%}, volume below the middle value {half:.3f}, expected 12", "" if same else "CHANGED")
for order in ("yx", "xy"):
    mesh = field.sel(z=0).transpose(*order).pyvista.mesh(x="x", y="y")
    share = misplaced(mesh)
    same = share == 0 if order == "yx" else share > .5
    changed |= not same
    print("order", *order, f"values at wrong points {share:.0%}", "" if same else "CHANGED")
for name, latitudes in (("rising", np.arange(0, 50, 10.)), ("falling", np.arange(40, -10, -10.))):
    map_ = xarray.DataArray(np.add.outer(latitudes, 1000 + np.arange(0, 60, 10.)), name="v",
                            coords={"lat": latitudes, "lon": np.arange(0, 60, 10.)})
    mesh = map_.pyvista.mesh(x="lon", y="lat")
    found = mesh.sample_over_line((5, 5, 0), (45, 35, 0), resolution=2)["v"]
    same = np.allclose(found, [1010, 1045, 1080]) if name == "rising" else np.allclose(found, 0)
    changed |= not same
    print(f"{name} latitudes: probes on the diagonal {np.round(found, 3).tolist()}, expected [1010, 1045, 1080]", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
