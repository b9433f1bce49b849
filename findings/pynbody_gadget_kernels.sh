#!/usr/bin/env bash
# pynbody spreads gas of GADGET files over twice its radius: central densities are an eighth.
#
# Surprise: `SmoothingLength` of GADGET is the radius at which the kernel becomes 0. pynbody takes it as its own `smooth`, whose
#   kernel becomes 0 at twice that. One particle of radius 0.25 has the radius 0.5 and an eighth of its density on
#   pynbody's grid; yt reads the same file as it is meant. Without the array pynbody computes its own, half of the distance
#   to a neighbor, which is consistent. `rho` comes from the file, so only images and grids are blurred.
# Versions: pynbody 2.8.0, yt 4.4.3, h5py 3.16.0, SciPy 1.17.1
# Seen: 2026-11
# Do: halve it after reading: s.gas["smooth"] /= 2.
# Source: V. Springel, "The cosmological simulation code GADGET-2", 2005, equation 4: W(r, h) is 0 for r > h. pynbody manual,
#   "Kernels": the cubic spline is 0 beyond two smoothing lengths.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet pynbody==2.8.0 yt==4.4.3 h5py==3.16.0 scipy==1.17.1 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import sys
from importlib.metadata import version

import h5py
import numpy as np
import pynbody
import yt
from scipy.spatial import cKDTree

yt.set_log_level(50)
print({name: version(name) for name in ("pynbody", "yt", "h5py", "scipy")})


def write(name, places, radius, density):
    count = len(places)
    with h5py.File(name, "w") as file:
        head = file.create_group("Header").attrs
        head["NumPart_ThisFile"] = head["NumPart_Total"] = [count, 0, 0, 0, 0, 0]
        head["NumPart_Total_HighWord"], head["MassTable"] = [0] * 6, [0.] * 6
        for key, value in {"Time": 1., "Redshift": 0., "BoxSize": 1., "NumFilesPerSnapshot": 1, "Omega0": .3, "OmegaLambda": .7,
                           "HubbleParam": 1., "Flag_Sfr": 0, "Flag_Cooling": 0, "Flag_StellarAge": 0, "Flag_Metals": 0,
                           "Flag_Feedback": 0, "Flag_DoublePrecision": 1}.items():
            head[key] = value
        gas = file.create_group("PartType0")
        gas["Coordinates"], gas["Velocities"] = places, np.zeros_like(places)
        gas["ParticleIDs"], gas["Masses"], gas["InternalEnergy"] = np.arange(count, dtype="u4"), np.ones(count), np.ones(count)
        gas["Density"] = np.full(count, density)
        if radius is not None:
            gas["SmoothingLength"] = np.full(count, radius)


radius, n = .25, 65
peak = 8 / np.pi / radius**3  # of the cubic spline that is 0 at this radius, for mass 1
write("one.hdf5", np.full((1, 3), .5), radius, peak)
axis = (np.arange(n) + .5) / n - .5
distances = np.sqrt(axis[:, None, None]**2 + axis[:, None]**2 + axis**2)

data = yt.load("one.hdf5")
data.use_sph_normalization = False
by_yt = np.array(data.arbitrary_grid([0, 0, 0], [1, 1, 1], dims=[n] * 3)["gas", "density"].to("code_mass/code_length**3"))
snapshot = pynbody.load("one.hdf5")
snapshot["pos"] -= .5
by_pynbody = np.array(pynbody.sph.to_3d_grid(snapshot.gas, qty="rho", nx=n, ny=n, nz=n, x2=.5))
snapshot.gas["smooth"] /= 2
halved = np.array(pynbody.sph.to_3d_grid(snapshot.gas, qty="rho", nx=n, ny=n, nz=n, x2=.5))
changed = False
for name, grid, reach, height in (("yt", by_yt, 1, 1), ("pynbody", by_pynbody, 2, 1 / 8), ("pynbody, smooth halved", halved, 1, 1)):
    found = distances[grid > 0].max() / radius, grid[n // 2, n // 2, n // 2] / peak
    same = abs(found[0] - reach) < .02 and abs(found[1] - height) < .02
    changed |= not same
    print(f"{name}: {found[0]:.3f} of the radius, {found[1]:.3f} of the central density, mass {grid.sum() / n**3:.3f}",
          "" if same else "CHANGED")

places = np.random.default_rng(1).random((2000, 3))
write("many.hdf5", places, None, 2000.)
of_distance = np.array(pynbody.load("many.hdf5").gas["smooth"]) / cKDTree(places, boxsize=1).query(places, 32)[0][:, -1]
same = abs(of_distance - .5).max() < 1e-6
changed |= not same
print(f"without SmoothingLength, pynbody's smooth is {of_distance.mean():.3f} of the distance to the 31st neighbor",
      "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
