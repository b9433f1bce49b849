"""Wrong values of every parameter of every public function: each is refused by name, and changes nothing."""

import contextlib
import dataclasses
import functools
import importlib.util
import inspect
import itertools
import os
import re
import tempfile
import unittest
import warnings

import numpy as np
from helpers import CELL, CUBE, UNIT_BOX

import pyvotess as vt
from pyvotess import autodiff, walls

N = 8
POINTS = np.random.default_rng(1).random((N, 3))
SURFACE = {"points": POINTS, "mesh": CUBE}
EACH = np.linspace(0.5, 1, N)
ALL = "neighbors,volumes,centroids,areas,faces,surfaces,radii,counts"


def masked(*shape):
    values = np.ma.masked_array(np.full(shape, 0.5), mask=False)
    values[0] = np.ma.masked
    return values


#: By label. Most are wrong for any parameter.
VALUES = {
    "None": None, "True": True, "0": 0, "1": 1, "3": 3, "-1": -1, "2**32 + 1": 2**32 + 1, "2**70": 2**70, "10**5000": 10**5000, "0.5": 0.5, "-0.5": -0.5,
    "nan": np.nan, "inf": np.inf, "-inf": -np.inf, "1j": 1j, "text": "text", "no text": "", "x": "x", "bytes": b"text",
    "zero": "a\0b", "surrogate": "\ud800", "[]": [], "()": (), "{}": {}, "[1, 2]": [1, 2], "ragged": [[1], [1, 2]],
    "dict": {"a": 1}, "set": {1, 2}, "object": object(), "type": int, "function": lambda: None,
    "0-d": np.array(0.5), "0-d nan": np.array(np.nan), "one": np.ones(1), "complex": np.full(N, 0.5j), "masked": masked(N),
    "nan each": np.full(N, np.nan), "masked points": masked(N, 3), "complex points": np.full((N, 3), 0.5j),
    "nan points": np.full((N, 3), np.nan), "texts": np.array(["a"] * N), "objects": np.array([object()] * N),
    "dates": np.array(["2020"] * N, "datetime64[s]"), "records": np.zeros(N, "i4,f8"), "4-d": np.zeros((N, 3, 1, 1)),
    "long": np.ones(N, np.longdouble), "texts in a list": ["a"] * N, "None in a list": [None] * N, "beside": [UNIT_BOX, None],
}  # fmt: skip

_FLAG, _COUNT = {"True", "0", "1"}, {"0", "1", "3"}
_LENGTH = {"0", "1", "3", "2**32 + 1", "2**70", "0.5", "0-d"}
_FUNCTION = {"None", "True", "function", "type"}
#: Values that a parameter of this name takes, or that are right for the type and fail later.
RIGHT = {
    **dict.fromkeys(("list_walls", "middles", "at_walls", "gradient", "verify", "maxima", "normalize", "follow", "merge"), _FLAG),
    **dict.fromkeys(("threads", "grid_resolution", "k_init", "chunk_size", "steps", "max_steps", "faces", "replicate", "shape"), _COUNT),
    "max_rows": {"None", *_COUNT},
    **dict.fromkeys(("gap", "min_edge", "min_face", "min_area", "tolerance", "radius", "angle", "over_relaxation"), _LENGTH),
    **dict.fromkeys(("progress", "density", "rows"), _FUNCTION),
    **dict.fromkeys(("domain", "within", "mesh", "mesh_repair", "repair", "box", "cell", "origin", "outside", "weights", "radii", "beside", "temporary", "ids"), {"None"}),
    "mesh_tolerance": {"None", "0"}, "want": {"[]", "()", "{}"}, "walls": {"None", "[]", "()"}, "only": {"None", "[]", "()", "[1, 2]"}, "fixed": {"[]", "()", "[1, 2]"},
    "periodic": {"None", "True", "0", "1", "no text", "x"}, "project": {"None", "0", "1"}, "axis": {"None", "0", "1"},
    "frames": {"[]", "()", "{}", "no text"}, "limits": {"None", "[1, 2]"}, "view": {"[1, 2]"}, "file": {"None"},
    "instructions": {"no text", "text", "x"}, "device": {"no text", "text", "x"}, "atoms": {"[]", "()"}, "pieces": {"[]", "()"},
    "sample": {"None", "2**32 + 1", *_COUNT}, "rng_seed": {"2**32 + 1", *_COUNT}, "memory": {"2**32 + 1"}, "seeds": {"2**32 + 1", *_FLAG},
    "lengths": {"None", "inf", *_LENGTH}, "edge_threshold": {"inf", *_LENGTH}, "min_edge": _LENGTH, "slice": {"None"}, "ax": {"None"},
    "threshold": {"-1", "-0.5", "inf", "-inf", *_LENGTH}, "values": {"nan each", "nan points"}, "gradients": {"None", "nan points"},
    "volumes": {"None", "nan each"}, "centroids": {"None", "nan points"}, "areas": {"None"}, "columns": {"None", "{}"},
    "width": {"None", "1", "3", "2**32 + 1", "2**70", "0.5", "0-d"}, "n": {"1", "3"}, "sharp": {"1", "3", "0.5", "0-d"},
    "color": {"None", "x", "nan each"}, "open": {"None"},
}  # fmt: skip
#: Other words of messages for a parameter.
WORDS = {"queries": "query", "origins": "query", "radii": "radius", "limits": "box", "vectors": "cell", "repair": "mesh_repair"}
#: Errors that need not name the parameter: the combination with another argument is wrong, which is named.
OTHERS = {
    ("tessellate in the plane", "points", "nan points"),
    ("autodiff.jax.tessellate", "points", "nan points"), ("autodiff.jax.tessellate", "weights", "nan each"),  # of JAX
}
#: Packages that right arguments need.
NEEDS = {
    "NaturalCoordinates.to_scipy": "scipy", "Tessellation.derivatives": "scipy", "Tessellation.plot": "matplotlib",
    "Tessellation.to_pyvista": "pyvista",
}  # fmt: skip
#: Public functions that are not called here, and why.
LEFT_OUT = {
    "Frame.with_columns": "write_frames() checks them",
    "Frame.tessellate": "its arguments are those of tessellate()",
    "Pieces.rings": "an index, as of a list",
    "devices": "no parameters",
    "Probes.voronoi_indices": "that of Tessellation",
    "read_frames": "the program clvotess checks its file",
}


def arrays_of(result):
    """Returns the bytes of all arrays in a result."""
    if isinstance(result, np.ndarray):
        return [result.tobytes()]
    if hasattr(result, "_data"):
        return [array.tobytes() for array in result._data.arrays.values()]
    if dataclasses.is_dataclass(result):
        result = [getattr(result, field.name) for field in dataclasses.fields(result)]
    return [part for one in result for part in arrays_of(one)] if isinstance(result, (list, tuple)) else []


def public_functions():
    """Yields the names of functions, and of methods with parameters of their own."""
    for name in dir(vt):
        thing = getattr(vt, name)
        if inspect.isfunction(thing) or thing in (vt.Tessellator, vt.Diagram, vt.Domain):
            yield name
        if inspect.isclass(thing):
            for method, function in inspect.getmembers(thing, inspect.isfunction):
                own = function.__module__.startswith("pyvotess") and not method.startswith("_")
                if own and len(inspect.signature(function).parameters) > 1:
                    yield f"{name}.{method}"


def calls():
    """Returns each public function with right arguments, by name, and perhaps the parameters to try.

    A name may end with words about the arguments.
    """
    t = vt.tessellate(POINTS, box=UNIT_BOX, want=ALL, device="cpu")
    in_mesh = vt.tessellate(POINTS, mesh=CUBE, device="cpu")
    periodic = vt.tessellate(POINTS, box=UNIT_BOX, periodic=True, want="faces", device="cpu")
    tessellator, diagram = vt.Tessellator(device="cpu"), vt.Diagram(POINTS, box=UNIT_BOX)
    rays = diagram.trace(POINTS, POINTS - 0.5, middles=True)
    slopes = np.ones((N, 3))
    with_jax = {}
    if importlib.util.find_spec("jax"):
        from pyvotess.autodiff.jax import tessellate

        with_jax["autodiff.jax.tessellate"] = (tessellate, {"points": np.float32(POINTS), "box": UNIT_BOX, "max_rows": 200})
    domain = {"points": POINTS, "box": UNIT_BOX}
    return {
        **with_jax,
        "tessellate": (vt.tessellate, {**domain, "device": "cpu"}),
        "tessellate in a cell": (vt.tessellate, {"points": POINTS, "cell": CELL}, ("cell", "origin", "periodic", "walls")),
        "tessellate in a mesh": (vt.tessellate, {"points": POINTS, "mesh": CUBE}, ("mesh", "mesh_repair", "min_face")),
        "tessellate in the plane": (
            vt.tessellate, {"points": POINTS[:, :2], "box": (0, 0, 1, 1)}, ("points", "box", "periodic", "walls", "weights"),
        ),
        "Domain": (vt.Domain, {"box": UNIT_BOX}),
        "Domain.box": (vt.Domain.box, {"limits": UNIT_BOX}),
        "Domain.cell": (vt.Domain.cell, {"vectors": CELL}),
        "Domain.mesh": (vt.Domain.mesh, {"mesh": CUBE, "repair": "merge"}, ("mesh", "repair", "within")),
        "Domain.replace": (vt.Domain.box(UNIT_BOX).replace, {}),
        "Tessellator": (vt.Tessellator, {}),
        "Tessellator.tessellate": (tessellator.tessellate, domain),
        "tessellate_stream": (vt.tessellate_stream, {"pieces": [POINTS], "rows": list().append, "memory": 10**7, "box": UNIT_BOX}),
        "fit_volumes": (vt.fit_volumes, {**domain, "volumes": EACH, "normalize": True, "tolerance": 0.1, "device": "cpu"}),
        "lloyd": (vt.lloyd, {**domain, "steps": 1, "device": "cpu"}),
        "lloyd of volumes": (vt.lloyd, {**domain, "steps": 0, "volumes": EACH, "normalize": True, "device": "cpu"}),
        "surface": (vt.surface, SURFACE),
        "lloyd_on_surface": (vt.lloyd_on_surface, {**SURFACE, "steps": 1}),
        "remesh": (vt.remesh, {"mesh": CUBE, "n": 4, "steps": 0}),
        "Remesh.save": (vt.remesh(CUBE, 4, steps=0).save, {"path": "r.obj"}),
        "transport_cost": (vt.transport_cost, {"tessellation": t}),
        "from_ase": (vt.from_ase, {"atoms": []}),
        "write_frames": (vt.write_frames, {"path": "t.xyz", "frames": []}),
        "autodiff.forward": (autodiff.forward, {"points": POINTS, "box": UNIT_BOX, "device": "cpu"}),
        "autodiff.vjp": (autodiff.vjp, {"t": t, "volumes": EACH}),
        "walls.sphere": (walls.sphere, {"center": (0, 0, 0), "radius": 1}),
        "walls.cylinder": (walls.cylinder, {"point": (0, 0, 0), "axis": (0, 0, 1), "radius": 1}),
        "walls.cone": (walls.cone, {"apex": (0, 0, 0), "axis": (0, 0, 1), "angle": 0.5}),
        "Diagram": (vt.Diagram, domain),
        "Diagram.locate": (diagram.locate, {"queries": POINTS}),
        "Diagram.trace": (diagram.trace, {"origins": POINTS, "directions": POINTS - 0.4}),
        "Diagram.probe": (diagram.probe, {"queries": POINTS[:2] + 1e-3}),
        "Diagram.natural_neighbors": (diagram.natural_neighbors, {"queries": POINTS}),
        "Diagram.interpolate": (diagram.interpolate, {"values": EACH, "queries": POINTS}),
        "Diagram.to_grid": (diagram.to_grid, {"values": EACH, "shape": 2}),
        "RayCells.integrate": (rays.integrate, {"values": EACH, "gradients": slopes}),
        "NaturalCoordinates.to_scipy": (diagram.natural_neighbors(POINTS).to_scipy, {"seeds": N}),
        "Tessellation.voronoi_indices": (t.voronoi_indices, {}),
        "Tessellation.pieces": (in_mesh.pieces, {}),
        "Tessellation.alpha_complex": (periodic.alpha_complex, {"replicate": 3}),
        "Tessellation.groups": (t.groups, {"labels": np.arange(N)}),
        "Tessellation.masses": (t.masses, {"density": np.ones((2, 2, 2))}),
        "Tessellation.shapes": (t.shapes, {}),
        "Tessellation.mesh_quality": (t.mesh_quality, {}),
        "Tessellation.watershed": (t.watershed, {"values": EACH}),
        "Tessellation.derivatives": (t.derivatives, {}),
        "Tessellation.image": (t.image, {"size": (64, 64)}),
        "Tessellation.plot": (t.plot, {"slice": ("z", 0.5)}),
        "Tessellation.save": (t.save, {"path": "t.npz"}),
        "Tessellation.save colors": (t.save, {"path": "t.glb"}),
        "Tessellation.to_pyvista": (t.to_pyvista, {}),
        "Tessellation.view": (t.view, {}),
        "Tessellation.verify": (t.verify, {}),
        "Pieces.mesh_quality": (in_mesh.pieces().mesh_quality, {}),
        "Pieces.save": (in_mesh.pieces().save, {"path": "p.obj"}),
        "Pieces.image": (in_mesh.pieces().image, {"size": (64, 64)}),
        "Network.image": (periodic.network().image, {"size": (64, 64)}),
        "Masses.cost": (t.masses(np.ones((2, 2, 2))).cost, {"places": POINTS}),
        "Network.largest_free": (periodic.network().largest_free, {}),
        "Zones.merge": (t.watershed(EACH).merge, {"threshold": 0.1}),
    }


class WrongValues(unittest.TestCase):
    """About 13,000 calls."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)

    def test_each_public_function_is_called(self):
        called = {name.split(" ")[0] for name in calls()}
        missing = [name for name in public_functions() if name not in called and name not in LEFT_OUT]
        self.assertEqual(missing, [])

    def complaint(self, call, function, given, name, label):
        """Calls with one wrong value. Returns what is wrong with the answer, or None."""
        try:
            function(**{**given, name: VALUES[label]})
        except (ValueError, TypeError, vt.VotessError) as error:
            if label in RIGHT.get(name, ()) or (call, name, label) in OTHERS:
                return None
            message = str(error)
            stem = name[:-1] if name.endswith("s") else name
            if "\n" not in message and re.search(rf"\b({re.escape(stem)}s?|{WORDS.get(name, name)})\b", message):
                return None
            return f"{type(error).__name__}: {message}"
        except Exception as error:  # a package may be missing
            right = label in RIGHT.get(name, ()) and (isinstance(error, ImportError) or name == "max_rows")
            return None if right or (call, name, label) in OTHERS else repr(error)
        return None if label in RIGHT.get(name, ()) else "accepted"

    def test_wrong_values_are_refused_by_name(self):
        before = {label: repr(value) for label, value in VALUES.items() if label != "10**5000"}
        wrong = []
        with warnings.catch_warnings(), open(os.devnull, "w") as nowhere, contextlib.redirect_stderr(nowhere):
            warnings.simplefilter("ignore")
            for call, (function, given, *some) in calls().items():
                right = call not in NEEDS or importlib.util.find_spec(NEEDS[call])
                answer = arrays_of(function(**given)) if right else None
                parameters = inspect.signature(function).parameters.values()
                names = {one.name for one in parameters if one.kind is not one.VAR_KEYWORD}
                if call.startswith("autodiff") and len(names) < len(parameters):
                    names.update(inspect.signature(vt.tessellate).parameters)
                for name in some[0] if some else sorted(names):
                    for label in VALUES:
                        complaint = self.complaint(call, function, given, name, label)
                        if complaint:
                            wrong.append(f"{call}({name}={label}): {complaint}")
                if right and answer != arrays_of(function(**given)):
                    wrong.append(f"{call}: another answer after the wrong calls")
        self.assertFalse(wrong, f"{len(wrong)} wrong answers:\n" + "\n".join(wrong[:100]))
        self.assertEqual({label: repr(VALUES[label]) for label in before}, before, "arguments changed")
        self.assertLessEqual(set(os.listdir()), {"t.npz", "t.glb", "t.xyz", "p.obj", "r.obj"})


class Words(unittest.TestCase):
    """Refusals name arguments of Python, whatever the library calls them."""

    def test_pairs_of_options(self):
        options = [
            ("points", POINTS[:, :2]), ("box", UNIT_BOX), ("box", "none"), ("box", "hull"), ("box", (0, 0, 0, 1, 1, 0)), ("cell", CELL),
            ("cell", np.ones((3, 3))), ("periodic", True), ("periodic", "x"), ("walls", [(1, 0, 0, 0.9)]), ("walls", [(0, 0, 0, 1)]),
            ("mesh", CUBE), ("mesh", (CUBE[0], CUBE[1][:-1])), ("mesh", (CUBE[0] + 0.5, CUBE[1])), ("mesh", (CUBE[0] / 2, CUBE[1])),
            ("outside", "drop"), ("outside", "keep"), ("only", [0]), ("only", [N]), ("min_face", 0.1), ("min_face", -1), ("min_area", 0.1),
            ("weights", EACH), ("radii", -EACH), ("duplicates", "error"), ("want", "vertices"), ("want", "counts,radii"), ("want", "none"),
            ("device", "none"), ("threads", 5000), ("instructions", "none"), ("precision", "double"),
        ]  # fmt: skip
        functions = {
            vt.tessellate: {"points": 1.1 * POINTS, "device": "cpu", "threads": 1},
            vt.Diagram: {"points": POINTS, "threads": 1},
            vt.fit_volumes: {"points": POINTS, "volumes": EACH, "max_steps": 1, "device": "cpu", "threads": 1},
            vt.tessellate_stream: {"pieces": [POINTS], "rows": list().append, "memory": 10**6, "threads": 1},
        }
        domains = ({}, {"only": [0]}, {"box": UNIT_BOX, "periodic": "x", "min_face": 0.5})
        t = [vt.tessellate(POINTS, want=want, device="cpu", **domain) for want in ("neighbors", "faces") for domain in domains]
        t += [vt.tessellate(POINTS, mesh=CUBE, device="cpu"), vt.tessellate(POINTS[:, :2], device="cpu")]
        calls = [getattr(one, name) for one in t for name in ("delaunay", "network", "pieces", "alpha_complex", "pairs", "rows")]
        calls += [lambda one=one: one.watershed(EACH) for one in t] + [lambda one=one: vt.transport_cost(one) for one in t]
        for function, given in functions.items():
            taken = inspect.signature(function).parameters
            some = [option for option in options if option[0] in taken]
            pairs = itertools.combinations(some, 2) if function is vt.tessellate else ([option] for option in some)
            calls += [functools.partial(function, **{**given, **dict(pair)}) for pair in pairs]
        names = "|".join(inspect.signature(vt.tessellate).parameters)
        foreign = re.compile(rf"::|options\.|`|--|(leave out|set|raise|give|use|without) ({names})\b(?!=)")
        refusals = set()
        for call in calls:
            try:
                call()
            except (ValueError, vt.VotessError) as error:
                refusals.add(str(error))
        self.assertGreater(len(refusals), 40)
        wrong = [refusal for refusal in refusals if foreign.search(refusal) or "\n" in refusal]
        self.assertFalse(wrong, "\n".join(wrong))


if __name__ == "__main__":
    unittest.main()
