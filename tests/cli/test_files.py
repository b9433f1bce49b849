"""Files that clvotess reads and writes, except text and .npy, each checked with another program.

VOTESS_CLI names the program.
"""

import shutil
import sys
import unittest

from all_frames_cases import AllFrames, FramesOfHdf5
from cli_test import CLI
from frame_cases import FileDomains, FrameFiles, Regressions
from hdf5_cases import Hdf5Files, Hdf5Module, Streamed
from lammps_cases import LammpsFiles
from mesh_cases import GeojsonFiles, GltfFiles, MeshFiles, SolverFiles
from picture_cases import Pictures
from reader_cases import ArrayFiles, Columns, HostileFiles, PlyFiles

__all__ = ["AllFrames", "ArrayFiles", "Columns", "FileDomains", "FrameFiles", "FramesOfHdf5", "GeojsonFiles", "GltfFiles", "Hdf5Files", "Hdf5Module", "HostileFiles", "LammpsFiles", "MeshFiles", "Pictures", "PlyFiles", "Regressions", "SolverFiles", "Streamed"]

if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
