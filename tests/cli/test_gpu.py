"""clvotess on Vulkan devices; these tests run under the validation layer, which finds misuse of Vulkan."""

import shutil
import sys
import unittest

from cli_test import CLI
from device_cases import Devices
from picture_cases import Pictures

__all__ = ["Devices", "Pictures"]

if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
