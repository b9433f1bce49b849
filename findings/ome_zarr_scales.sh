#!/usr/bin/env bash
# ngff-zarr and ome-zarr lose the voxel size of OME-Zarr images that state it once for all levels.
#
# Surprise: in OME-Zarr 0.4 and 0.5 each level has its own scale, and the multiscale image may have one more for all levels,
#   applied after it. So a writer may give levels of 1, 2 and 4 pixels, and the size of a pixel once. bioio-ome-zarr multiplies
#   both and finds voxels of 2 by 0.5 by 0.25 micrometers. ngff-zarr gives 1 by 1 by 1 micrometers at the origin, and ome-zarr
#   passes on only the scales of the levels. So volumes are 4 times too large here and cells are stretched along the wrong axes.
#   An image that ngff-zarr writes again has lost the size for good. Nothing warns. Images with the whole scale in each level
#   are right.
# Versions: ngff-zarr 0.50.0, ome-zarr 0.18.0, bioio-ome-zarr 3.8.1, ome-zarr-models 1.7, zarr 3.1.6
# Seen: 2026-12
# Do: read multiscales[0]["coordinateTransformations"] by zarr, and apply it after the scale and translation of each level.
# Source: OME-Zarr specification 0.4 and 0.5, "multiscales" metadata: coordinateTransformations of the dictionary, applied to
#   all resolution levels after those of the level.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet ngff-zarr==0.50.0 ome-zarr==0.18.0 bioio-ome-zarr==3.8.1 ome-zarr-models==1.7 zarr==3.1.6 numpy==2.4.6

venv/bin/python -W ignore - 2>errors <<'EOF' || { code=$?; cat errors; exit $code; }
import sys
from importlib.metadata import version

import ngff_zarr
import numpy as np
import zarr
from bioio_ome_zarr import Reader
from ome_zarr.io import parse_url
from ome_zarr.reader import Reader as Nodes
from ome_zarr_models import open_ome_zarr

print({name: version(name) for name in ("ngff-zarr", "ome-zarr", "bioio-ome-zarr", "ome-zarr-models", "zarr")})
voxel, corner = np.array([2., .5, .25]), np.array([100., 200., 300.])
levels = np.array([[1., 1., 1.], [1., 2., 2.]])
shifts = np.array([[0., 0., 0.], [0., .5, .5]])


def steps(scale, translation):
    return [{"type": "scale", "scale": list(scale)}, {"type": "translation", "translation": list(translation)}]


def by_bioio(name, level):
    reader = Reader(name)
    reader.set_resolution_level(level)
    return [reader.scale.Z, reader.scale.Y, reader.scale.X]


def by_ngff_zarr(name, level):
    image = ngff_zarr.from_ngff_zarr(name).images[level]
    return [image.scale[axis] for axis in "zyx"], [image.translation[axis] for axis in "zyx"]


def by_ome_zarr(name, level):
    node = next(Nodes(parse_url(name))())
    return [step["scale"] for step in node.metadata["coordinateTransformations"][level] if step["type"] == "scale"][0]


changed = False
for edition in ("0.4", "0.5"):
    for once in False, True:
        name = f"{edition}_{once}.zarr"
        group = zarr.open_group(name, mode="w", zarr_format=2 if edition == "0.4" else 3)
        data = np.zeros((4, 8, 8), np.uint16)
        datasets = []
        for k, array in enumerate((data, data[:, ::2, ::2])):
            group.create_array(str(k), data=array, chunks=array.shape, **({} if edition == "0.4" else {"dimension_names": list("zyx")}))
            own = steps(levels[k], shifts[k]) if once else steps(levels[k] * voxel, shifts[k] * voxel + corner)
            datasets.append({"path": str(k), "coordinateTransformations": own})
        image = {"name": "a", "axes": [{"name": axis, "type": "space", "unit": "micrometer"} for axis in "zyx"], "datasets": datasets}
        if once:
            image["coordinateTransformations"] = steps(voxel, corner)
        if edition == "0.4":
            group.attrs["multiscales"] = [{**image, "version": edition}]
        else:
            group.attrs["ome"] = {"version": edition, "multiscales": [image]}
        open_ome_zarr(zarr.open_group(name, mode="r"))  # raises if the file is not valid
        ngff_zarr.to_ngff_zarr(f"again_{name}", ngff_zarr.from_ngff_zarr(name), version=edition)
        for k in range(2):
            bioio, (ngff, place), ome = by_bioio(name, k), by_ngff_zarr(name, k), by_ome_zarr(name, k)
            again = by_bioio(f"again_{name}", k)
            lost = levels[k] if once else levels[k] * voxel
            same = np.allclose(bioio, levels[k] * voxel) and all(np.allclose(found, lost) for found in (ngff, ome, again)) and \
                np.allclose(place, shifts[k] if once else shifts[k] * voxel + corner)
            changed |= not same
            print(f"{edition}, size stated {'once' if once else 'in each level'}, level {k}: bioio {bioio}, ngff-zarr {ngff} at {place}, ome-zarr {ome}, "
                  f"bioio after ngff-zarr wrote it {again}", "" if same else "CHANGED")
sys.exit(bool(changed))
EOF
