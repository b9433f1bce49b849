"""What clvotess promises on its command line, line by line.

VOTESS_CLI names the program. Most tests run it in an empty folder of their own and look at exit code, stdout, stderr
and the files that are left. Answers are compared with plain arithmetic here, and with Voro++ where it is installed.
"""

import shutil
import sys
import unittest

from cli_test import CLI
from domain_cases import FileDomains
from file_cases import Files
from hdf5_cases import Hdf5Files
from input_cases import Source
from output_cases import ArrayOutput, TextOutput
from reader_cases import ArrayFiles, LammpsFiles, PlyFiles
from usage_cases import Usage
from vtk_cases import VtkFiles

__all__ = ["ArrayFiles", "ArrayOutput", "FileDomains", "Files", "Hdf5Files", "LammpsFiles", "PlyFiles", "Source",
           "TextOutput", "Usage", "VtkFiles"]

if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
