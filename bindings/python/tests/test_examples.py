"""Examples in docstrings: each public function has one, and each runs."""

import doctest
import importlib.util
import inspect
import os
import unittest
from pathlib import Path
from unittest import mock

from helpers import Folder, uniform

import pyvotess as vt

#: Packages that an example needs.
NEEDS = {
    "from_ase": "ase", "Neighbors.to_scipy": "scipy", "NaturalCoordinates.to_scipy": "scipy", "Network.to_networkx": "networkx",
    "Network.to_openpnm": "openpnm", "AlphaComplex.to_gudhi": "gudhi", "Tessellation.derivatives": "scipy",
    "Tessellation.plot": "matplotlib", "Tessellation.to_dataframe": "pandas", "Tessellation.to_freud": "freud",
    "Tessellation.to_networkx": "networkx", "Tessellation.to_pyvista": "pyvista", "Tessellation.to_scipy": "scipy",
}  # fmt: skip
#: Functions without an example, and why.
LEFT_OUT = {"StreamRows.neighbors": "that of tessellate_stream() has it"}


def public_functions():
    """Yields name and function: functions of the package and of modules that it shows, constructors, and methods."""
    for module in (vt, vt.walls, vt.autodiff):
        for name in dir(module):
            thing = getattr(module, name)
            of = getattr(thing, "__module__", "")
            if name.startswith("_") or not (of.startswith("pyvotess") if module is vt else of == module.__name__):
                continue
            if inspect.isfunction(thing) or thing in (vt.Tessellator, vt.Diagram, vt.Domain):
                yield name, thing
            if inspect.isclass(thing) and module is vt:
                for method, function in inspect.getmembers(thing, lambda one: inspect.isfunction(one) or inspect.ismethod(one)):
                    if not method.startswith("_") and function.__module__.startswith("pyvotess"):
                        yield f"{name}.{method}", function


class Examples(Folder):
    def test_all(self):
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)
        vt.write_frames("run.dump", [vt.Frame(k, uniform(20, k), vt.Domain.box((0, 0, 0, 1, 1, 1))) for k in range(2)])
        parser, flags = doctest.DocTestParser(), doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
        runner = doctest.DocTestRunner(optionflags=flags)
        lines = []

        def run(name, text, names):
            example = parser.get_doctest(text, names, name, None, None)
            runner.run(example, out=lines.append, clear_globs=False)
            return example.globs

        names = run("pyvotess", vt.__doc__, {})
        self.assertIs(names["vt"], vt)
        without, seen = [], set()
        with mock.patch.dict(os.environ, MPLBACKEND="agg"):
            for name, function in public_functions():
                text = inspect.getdoc(function) or ""
                if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None or function in seen:
                    continue
                seen.add(function)
                if ">>>" in text:
                    run(name, text, names)
                elif name not in LEFT_OUT:
                    without.append(name)
        self.assertEqual("".join(lines), "")
        self.assertEqual(without, [])

    def test_reference(self):
        """Each name of the package has its place in the reference."""
        pages = Path(__file__).parent.parent / "docs/pages"
        text = "".join(page.read_text("utf-8") for page in pages.glob("python*.md"))
        self.assertEqual([name for name in dir(vt) if name != "__version__" and f"::: pyvotess.{name}\n" not in text], [])


if __name__ == "__main__":
    unittest.main()
