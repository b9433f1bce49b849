#!/usr/bin/env bash
# yt reads no particle from openPMD files, and takes z for x in their meshes.
#
# Surprise: openPMD-api writes 1000 particles in the box 1 x 2 x 4 and a mesh of rho = x + 10 y + 100 z. openpmd-viewer reads
#   both. yt counts 1000 particles, but their positions are an empty array, without an exception or a warning. A mesh whose axes
#   are labeled z, y, x, as programs in C++ and Python write it, is read with its first axis as x: the box becomes 4 x 2 x 1, and
#   rho is off by up to 384. Labels x, y, z are right. A mesh whose values lie at the lower corners of its voxels, as the file
#   says by `position`, is moved by half a voxel.
# Versions: yt 4.4.3, openPMD-api 0.17.1.post4, openPMD-viewer 1.11.0
# Seen: 2026-11
# Do: read by openpmd-viewer, and hand the arrays to yt.load_uniform_grid or yt.load_particles in the order x, y, z.
# Source: openPMD standard 1.1, "Mesh Based Records" (axisLabels, dataOrder, position) and "Particle Records". yt manual,
#   "Loading openPMD Data", which states both.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet yt==4.4.3 openPMD-api==0.17.1.post4 openPMD-viewer==1.11.0 h5py==3.16.0 numpy==2.4.6

venv/bin/python -W ignore - <<'EOF'
import os
import sys
from importlib.metadata import version

import numpy as np
import openpmd_api as openpmd
import yt
from openpmd_viewer import OpenPMDTimeSeries

yt.set_log_level(50)
print({name: version(name) for name in ("yt", "openPMD-api", "openPMD-viewer")})
sides, voxel, count = {"x": 1., "y": 2., "z": 4.}, 1 / 8, 1000
random = np.random.default_rng(1)
points = {axis: random.random(count) * side for axis, side in sides.items()}


def write(folder, labels, place):
    os.mkdir(folder)
    series = openpmd.Series(folder + "/data_%T.h5", openpmd.Access.create)
    step = series.iterations[0]
    step.set_time(0.).set_dt(1.).set_time_unit_SI(1.)
    particles = step.particles["electrons"]
    layout = openpmd.Dataset(np.dtype("float64"), [count])
    for axis in sides:
        for record, values in (("position", points[axis]), ("positionOffset", 0.), ("momentum", points[axis])):
            component = particles[record][axis]
            component.reset_dataset(layout)
            component.store_chunk(values) if record != "positionOffset" else component.make_constant(values)
            component.unit_SI = 1.
    length, mass, time = openpmd.Unit_Dimension.L, openpmd.Unit_Dimension.M, openpmd.Unit_Dimension.T
    particles["position"].unit_dimension = particles["positionOffset"].unit_dimension = {length: 1}
    particles["momentum"].unit_dimension = {length: 1, mass: 1, time: -1}
    weight = particles["weighting"][openpmd.Mesh_Record_Component.SCALAR]
    weight.reset_dataset(layout)
    weight.make_constant(1.)
    mesh = step.meshes["rho"]
    mesh.axis_labels = list(labels)
    mesh.grid_spacing, mesh.grid_global_offset, mesh.grid_unit_SI = [voxel] * 3, [0.] * 3, 1.
    rho = mesh[openpmd.Mesh_Record_Component.SCALAR]
    rho.position, rho.unit_SI = [place] * 3, 1.
    ticks = [(np.arange(sides[axis] / voxel) + place) * voxel for axis in labels]
    at = dict(zip(labels, np.meshgrid(*ticks, indexing="ij")))
    values = at["x"] + 10 * at["y"] + 100 * at["z"]
    rho.reset_dataset(openpmd.Dataset(values.dtype, values.shape))
    rho.store_chunk(values.copy())
    series.flush()
    series.close()


changed = False
for labels, place, extent, stated in (("xyz", .5, [1, 2, 4], 0), ("zyx", .5, [4, 2, 1], 383.625), ("xyz", 0., [1, 2, 4], 6.9375)):
    folder = f"{labels}_{place}"
    write(folder, labels, place)
    viewer = OpenPMDTimeSeries(folder)
    read = viewer.get_particle(["x", "y", "z"], species="electrons", iteration=0)
    rho, grid = viewer.get_field("rho", iteration=0)
    at = dict(zip((grid.axes[i] for i in range(3)), np.meshgrid(*(getattr(grid, grid.axes[i]) for i in range(3)), indexing="ij")))
    error = abs(rho - at["x"] - 10 * at["y"] - 100 * at["z"]).max()
    right = all(np.array_equal(a, b) for a, b in zip(read, points.values())) and error < 1e-9
    print(f"{folder} by openpmd-viewer: {len(read[0])} particles; rho is off by {error:.3g}")
    data = yt.load(folder + "/data_0.h5")
    all_of_it = data.all_data()
    x = all_of_it["io", "particle_position_x"]
    error = float(abs(all_of_it["openPMD", "rho"] - (all_of_it["index", "x"] + 10 * all_of_it["index", "y"] +
                                                     100 * all_of_it["index", "z"]).d).max())
    size = data.domain_width.d
    same = right and data.particle_type_counts == {"io": count} and len(x) == 0 and np.allclose(size, extent) and \
        abs(error - stated) < 1e-4
    changed |= not same
    print(f"{folder} by yt: {data.particle_type_counts['io']} particles, {len(x)} read; box {size}; rho is off by {error:.4f}",
          "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
