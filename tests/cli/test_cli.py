"""The command line of clvotess.

VOTESS_CLI names the program. Most tests run it in an empty folder and check exit code, stdout, stderr and files. Results
are compared with plain arithmetic, and with Voro++ if it is installed.
"""

import shutil
import sys
import unittest

from cli_test import CLI
from file_cases import Files
from fit_cases import Volumes
from input_cases import Source
from output_cases import AlphaComplexes, ArrayOutput, TextOutput, VoroppCommand
from plane_cases import Plane
from query_cases import Interpolate, Locate, Probe, Stops, ToGrid, Trace
from solid_cases import Mesh
from surface_cases import OnSurface
from usage_cases import Usage, Words

__all__ = ["AlphaComplexes", "ArrayOutput", "Files", "Locate", "Mesh", "Probe", "Interpolate", "OnSurface", "Plane", "Source", "Stops", "TextOutput", "ToGrid", "Trace", "Usage", "Volumes", "Words",
           "VoroppCommand"]

if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
