#!/usr/bin/env bash
# An .h5md of MDAnalysis is incomplete after close() of its writer, until Python deletes the writer.
#
# Surprise: frames are written inside a with block, whose end calls close(). The file stays open in HDF5: another program cannot
#   open it because of the lock, and a copy that is made then is damaged, since parts of it are still in memory. MDAnalysis itself
#   in the same process reads the original, so tests pass. When the writer is deleted, file and copies are right. A run that
#   ends by a signal or os._exit() after the block leaves a damaged file.
# Versions: MDAnalysis 2.11.0, h5py 3.16.0
# Seen: 2026-11
# Do: call writer.h5md_file.close() at the end of the block, or delete the writer.
# Source: MDAnalysis manual, "Trajectory Writers" (close() closes the trajectory; writers are context managers); HDF5 manual,
#   "File Locking" and H5Fclose (which writes what is in memory).
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
"${PYTHON:-python3}" -m venv venv
venv/bin/pip install --quiet MDAnalysis==2.11.0 h5py==3.16.0 numpy==2.4.6

unset HDF5_USE_FILE_LOCKING
venv/bin/python -W ignore - <<'EOF'
import gc
import shutil
import subprocess
import sys
from importlib.metadata import version

import MDAnalysis
import numpy as np

print({name: version(name) for name in ("MDAnalysis", "h5py")})
CODE = "import h5py, sys; print(h5py.File(sys.argv[1])['particles/trajectory/position/value'].shape)"


def elsewhere(file):
    done = subprocess.run([sys.executable, "-c", CODE, file], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else "refused"


changed = False
for end, stated in (("with block", ("refused", "refused")), ("h5md_file.close()", ("(3, 50, 3)", "(3, 50, 3)")),
                    ("deleted writer", ("(3, 50, 3)", "(3, 50, 3)"))):
    atoms = MDAnalysis.Universe.empty(50, trajectory=True)
    file = end.split()[0] + ".h5md"
    writer = MDAnalysis.Writer(file, 50, velocities=False, forces=False, convert_units=False)
    with writer:
        for _ in range(3):
            atoms.atoms.positions = np.random.default_rng(1).random((50, 3))
            atoms.dimensions = [10, 9, 8, 90, 90, 90]
            writer.write(atoms.atoms)
    if end == "h5md_file.close()":
        writer.h5md_file.close()
    if end == "deleted writer":
        del writer
        gc.collect()
    shutil.copy(file, "copy.h5md")
    seen = elsewhere(file), elsewhere("copy.h5md")
    same = seen == stated
    changed |= not same
    print(f"after the {end}: another process sees {seen[0]}, in a copy {seen[1]}", "" if same else "CHANGED")
sys.exit(changed)
EOF
