"""What a type checker says about a user's script."""

import importlib.util
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from helpers import PACKAGE_PARENT

SCRIPT = """
import numpy as np
import pyvotess as vt

points = np.zeros((4, 3))
box = vt.Domain.box((0, 0, 0, 1, 1, 1), periodic="xy")
t = vt.tessellate(points, box, want="neighbors,volumes", weights=[1.0] * 4)
total: float = float(t.volumes.sum())
d = vt.Diagram(points, box=(0, 0, 0, 1, 1, 1))
again: vt.Domain = d.domain
field = d.interpolate(points @ (1, 2, 3), points)
values, slopes = d.interpolate([1.0] * 4, points, gradient=True)
"""
WRONG = ('vt.tessellate(points, want=3)', 'vt.tessellate(points, boks=1)', 'vt.Diagram(points, outside="hide")', "t.volume")


@unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy is not installed")
class Types(unittest.TestCase):
    def test_script(self):
        """A right script has no errors, and each wrong line has one."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "script.py"
            path.write_text(SCRIPT + "\n".join(WRONG) + "\n")
            command = [sys.executable, "-m", "mypy", "--no-incremental", "--ignore-missing-imports", str(path)]
            done = subprocess.run(command, cwd=folder, env={"MYPYPATH": str(PACKAGE_PARENT)}, capture_output=True, text=True)
            errors = [line for line in done.stdout.splitlines() if " error: " in line]
            first = SCRIPT.count("\n") + 1
            self.assertEqual([line.split(": ")[0] for line in errors], [f"script.py:{first + k}" for k in range(len(WRONG))], done.stdout)


if __name__ == "__main__":
    unittest.main()
