#!/usr/bin/env bash
# yt spreads the gas of SWIFT snapshots over 0.55 of its radius: maps are too sharp, and have gaps.
#
# Surprise: a particle of mass 1 and smoothing length h = 0.05. swiftsimio paints it up to 0.0913, which is SWIFT's radius: h
#   times 1.825742 for the cubic spline in three dimensions. yt takes h for the radius, so its column density in the middle is 3.1
#   times as high. The mass is kept by both, so a check of the sum passes. Slices of a smooth medium drop to 0
#   between the particles. Before that, yt needs NumPy below 2.4: SWIFT stores the numbers of its header as arrays of one entry,
#   which swiftsimio expects, and yt converts them in a way that NumPy 2.4 refuses.
# Versions: yt 4.4.3, swiftsimio 12.4.0, NumPy 2.3.5 and 2.4.6
# Seen: 2026-11
# Do: draw such snapshots by swiftsimio, or multiply SmoothingLengths by the factor of the kernel in a copy for yt.
# Source: Dehnen and Aly (2012), whose h SWIFT's manual takes: the radius H of the kernel is a multiple of h, by kernel and
#   dimension. swiftsimio manual, "Visualisation". yt manual, "SPH particle data", where the kernel ends at the smoothing length.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet yt==4.4.3 swiftsimio==12.4.0 numpy==2.3.5
cat > seen.py <<'EOF'
import sys
from importlib.metadata import version

import h5py
import numpy as np
import yt
from swiftsimio import load
from swiftsimio.visualisation import project_gas

yt.set_log_level(50)
print({name: version(name) for name in ("yt", "swiftsimio", "numpy")})
h, gamma = .05, 1.825742
units = {f"Unit {name} in cgs ({sign})": np.ones(1) for name, sign in (("length", "U_L"), ("mass", "U_M"), ("time", "U_t"),
                                                                      ("temperature", "U_T"), ("current", "U_I"))}
text = np.bytes_
counts = np.array([1, 0, 0, 0, 0, 0, 0])
groups = {
    "Header": {"BoxSize": np.ones(3), "NumPart_ThisFile": counts, "NumPart_Total": counts, "NumPart_Total_HighWord": 0 * counts,
               "NumFilesPerSnapshot": [1], "ThisFile": [0], "Dimension": [3], "Redshift": [0.], "Scale-factor": [1.],
               "Time": [0.], "MassTable": np.zeros(7), "InitialMassTable": np.zeros(7), "NumPartTypes": [7], "Code": text("SWIFT"),
               "RunName": text("one particle"), "OutputType": text("FullVolume")},
    "Units": units,
    "InternalCodeUnits": units,
    "Policy": {"cosmological integration": [0], "hydrodynamics": [1], "self gravity": [0]},
    "Parameters": {"InitialConditions:periodic": text("1")},
    "HydroScheme": {"Kernel function": text("Cubic spline (M4)"), "Kernel eta": [1.2348], "Scheme": text("SPHENIX"),
                    "Dimension": [3], "Adiabatic index": [5 / 3]},
    "SubgridScheme": {},
    "Cosmology": {"Cosmological run": [0], "Redshift": [0.], "Scale-factor": [1.], "H0 [internal units]": [0.], "h": [0.],
                  "Omega_m": [0.], "Omega_lambda": [0.]},
    "PartType0": {}}
with h5py.File("one.hdf5", "w") as file:
    for name, attributes in groups.items():
        file.create_group(name).attrs.update(attributes)
    file["GasParticles"] = h5py.SoftLink("/PartType0")
    for name, values, length, mass, time in (("Coordinates", np.full((1, 3), .5), 1, 0, 0), ("Masses", [1.], 0, 1, 0),
                                             ("SmoothingLengths", [h], 1, 0, 0), ("Densities", [1.], -3, 1, 0),
                                             ("Velocities", np.zeros((1, 3)), 1, 0, -1), ("InternalEnergies", [1.], 2, 0, -2),
                                             ("ParticleIDs", [1], 0, 0, 0)):
        array = file["PartType0"].create_dataset(name, data=values)
        array.attrs.update({
            "U_I exponent": [0.], "U_L exponent": [float(length)], "U_M exponent": [float(mass)], "U_t exponent": [float(time)],
            "U_T exponent": [0.], "a-scale exponent": [0.], "h-scale exponent": [0.], "Description": text(name),
            "Conversion factor to CGS (not including cosmological corrections)": [1.], "Value stored as physical": [0],
            "Expression for physical CGS units": text(""), "Property can be converted to comoving": [1]})

pixels = 801


def measure(image):
    row = np.flatnonzero(image[pixels // 2] > 0)
    return (row[-1] - row[0] + 1) / 2 / pixels, image.sum() / pixels ** 2, image.max()


by_swiftsimio = measure(np.array(project_gas(load("one.hdf5"), resolution=pixels, project="masses", parallel=False)))
print("swiftsimio: radius {:.4f}, mass {:.3f}, middle {:.0f}".format(*by_swiftsimio), f"(h is {h}, H is {gamma * h:.4f})")
try:
    dataset = yt.load("one.hdf5")
except TypeError as error:
    print("yt refuses the file:", error)
    sys.exit(4)
projection = dataset.proj(("gas", "density"), "z")
image = projection.to_frb((1, "code_length"), pixels, center=[.5] * 3)["gas", "density"].to("code_mass/code_length**2")
by_yt = measure(np.nan_to_num(np.array(image)))
print("yt: radius {:.4f}, mass {:.3f}, middle {:.0f}".format(*by_yt))
same = abs(by_swiftsimio[0] / (gamma * h) - 1) < .05 and abs(by_yt[0] / h - 1) < .05 and \
    abs(by_swiftsimio[1] - 1) < .03 and abs(by_yt[1] - 1) < .03 and 3 < by_yt[2] / by_swiftsimio[2] < 3.6
sys.exit(0 if same else "CHANGED")
EOF
venv/bin/python -W ignore seen.py
venv/bin/pip install --quiet numpy==2.4.6
code=0
venv/bin/python -W ignore seen.py || code=$?
[[ $code -eq 4 ]] || { echo "CHANGED: yt with NumPy 2.4"; exit 1; }
