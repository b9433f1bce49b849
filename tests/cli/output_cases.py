"""Text rows and NumPy archives."""

import io
import os
import re
import shutil
import struct
import subprocess
import sys
import zipfile

import numpy as np

from cli_test import ROOT, CUBE, CUBE_BOX, CUBE_NEIGHBORS, CliTest, random_points, text_of

sys.path.append(str(ROOT / "tools"))
from arrays import read_table  # noqa: E402


class AlphaComplexes(CliTest):
    def test_alpha(self):
        """A lattice: 27 copies of one seed."""
        self.put("a.txt", "0 0 0\n")
        domain = ("a.txt", "--box", "0,0,0,1,1,1", "--periodic")
        self.run_cli(*domain, "--alpha", "3", "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            counts = [len(arrays[f"alpha_values_{k}"]) for k in range(4)]
            self.assertEqual(counts[0] - counts[1] + counts[2] - counts[3], 0)
            self.assertEqual(arrays["alpha_seeds_0"].tolist(), list(range(27)))
            self.assertEqual(arrays["alpha_seeds_3"].shape, (counts[3], 4))
            self.assertEqual(arrays["alpha_shifts_2"].shape, (counts[2], 9))
            np.testing.assert_array_equal(arrays["alpha_values_3"], 0.75)
            self.assertEqual(set(arrays["alpha_values_1"].tolist()), {0.25, 0.5, 0.75})
            self.assertTrue(arrays["alpha_gabriel_1"].all())
        self.refuse(*domain, "--alpha", "1", "-o", "out.npz", says="replicate it")
        self.refuse(*domain, "--alpha", "0", "-o", "out.npz", says="at least 1")
        self.refuse(*domain, "--alpha", "3", "-o", "out.txt", says=".npz or .h5")
        self.refuse(*domain, "--alpha", "3", "--memory", "1G", "-o", "out.npz", says="--alpha")
        self.refuse(*domain, "--alpha", "3", "--only", "0", "-o", "out.npz", says="only")


class TextOutput(CliTest):
    def test_points_at_the_upper_bound(self):
        """In .xyz, which states lengths and a corner, the sum of both must not fall below the bound."""
        random = np.random.default_rng(1)
        for trial in range(12):
            lower, upper = np.sort(random.uniform(-1, 1, (2, 3)).round(1 + trial % 2), axis=0) + [[0], [0.1]]
            self.put("a.txt", text_of([upper, lower, (lower + upper) / 2]))
            box = ",".join(map(repr, [*lower.tolist(), *upper.tolist()]))
            self.run_cli("a.txt", f"--box={box}", "-o", "b.xyz", "-o", "b.dump")
            for name in ("b.xyz", "b.dump"):
                self.run_cli(name, "--verify")

    def test_default_format(self):
        self.put("a.txt", CUBE)
        expected = [f"{i} " + " ".join(map(str, row)) for i, row in enumerate(CUBE_NEIGHBORS)]
        self.run_cli("a.txt", "--box", CUBE_BOX, "-o", "out.txt")
        self.assertEqual((self.folder / "out.txt").read_text(), "\n".join(expected) + "\n")
        self.assertEqual(self.rows("a.txt", "--box", CUBE_BOX), expected)
        self.assertEqual(self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i %n"), expected)

    def test_codes(self):
        self.put("a.txt", CUBE)
        row = self.rows("a.txt", "--box", CUBE_BOX, "--format",
                        "i=%i x=%x y=%y z=%z q=%q w=%w s=%s n=%n v=%v c=%c 5%%n\t.")[5]
        self.assertEqual(row, "i=5 x=1 y=0 z=1 q=1 0 1 w=8 s=6 n=1 4 7 v=1 c=0 0 0 5%n\t.")
        self.assertEqual(self.rows("a.txt", "--format", "%%i"), ["%i"] * 8)
        self.assertEqual(self.rows("a.txt", "--format", "%n%i", "--box", CUBE_BOX)[0], "1 2 40")

    def test_bad_codes(self):
        self.put("a.txt", CUBE)
        for form, says in [("%i %k", "'%k'"), ("%b", "'%b'"), ("%", "%%"), ("%i %", "%%"), ("", "empty"),
                           ("% i", "'% '"),
                           ("%I", "'%I'"), ("%i\n%n", "line end")]:
            self.refuse("a.txt", "-o", "out.txt", "--format", form, says=["--format", says])

    def test_walls(self):
        self.put("a.txt", CUBE)
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--list-walls", "--format", "%n")
        for i, row in enumerate(rows):
            walls = [-5 - (i >> 2), -3 - (i >> 1 & 1), -1 - (i & 1)]
            self.assertEqual([int(j) for j in row.split()], walls + CUBE_NEIGHBORS[i])
        self.run_cli("a.txt", "--box", CUBE_BOX, "--list-walls", "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["indices"][:6].tolist(), [-5, -3, -1, 1, 2, 4])

    def test_ids_name_rows_and_neighbors(self):
        ids = [50, 2**62, -3, 7, 1000, -1, 8, 9]
        self.put("a.txt", "".join(f"{i} {row}\n" for i, row in zip(ids, CUBE.splitlines())))
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%i:%n")
        self.assertEqual(rows, [f"{ids[i]}:" + " ".join(map(str, sorted(ids[j] for j in row)))
                                for i, row in enumerate(CUBE_NEIGHBORS)])
        rows = self.rows("a.txt", "--box", CUBE_BOX, "--format", "%n", "--list-walls")
        self.assertEqual(rows[0], "-5 -3 -1 " + " ".join(map(str, sorted(ids[j] for j in CUBE_NEIGHBORS[0]))))
        # Arrays hold indices of rows, not ids.
        self.run_cli("a.txt", "--box", CUBE_BOX, "-o", "out.npz")
        with np.load(self.folder / "out.npz") as arrays:
            self.assertEqual(arrays["indices"].tolist(), sum(CUBE_NEIGHBORS, []))

    def test_areas(self):
        # A seed between two others whose ids and rows have opposite orders.
        self.put("a.txt", "7 0.5 0.5 0.5\n9 2 0.5 0.5\n8 0.5 2.5 0.5\n")
        box = ["--box", "0,0,0,4,4,1"]
        rows = self.rows("a.txt", *box, "--format", "%n|%f")
        areas = [dict(zip(n.split(), map(float, f.split()))) for n, f in (row.split("|") for row in rows)]
        self.assertEqual(rows[0].split("|")[0], "8 9")
        self.assertAlmostEqual(areas[0]["8"], 1.25)
        self.assertAlmostEqual(areas[0]["9"], 1.5)
        self.assertAlmostEqual(areas[1]["7"], 1.5)
        self.run_cli("a.txt", *box, "-o", "out.npz", "--want", "areas")
        with np.load(self.folder / "out.npz") as arrays:
            np.testing.assert_allclose(arrays["face_areas"][:2], [1.5, 1.25], rtol=1e-13)
            self.assertEqual(arrays["indices"][:2].tolist(), [1, 2])
        rows = self.rows("a.txt", *box, "--list-walls", "--format", "%F %f")
        for row in rows:
            total, *parts = map(float, row.split())
            self.assertAlmostEqual(total, sum(parts), places=12)
        self.assertAlmostEqual(float(rows[0].split()[0]), 2 * 1.25 * 1.5 + 2 * (1.25 + 1.5), places=12)

    def test_numbers_read_back(self):
        points = random_points(300)
        self.put("a.npy", points)
        rows = [row.split() for row in self.rows("a.npy", "--format", "%q %x %y %z %v %c")]
        self.run_cli("a.npy", "-o", "out.npz", "--want", "volumes,centroids")
        values = np.array(rows, float)
        np.testing.assert_array_equal(values[:, :3], points)
        np.testing.assert_array_equal(values[:, 3:6], points)
        with np.load(self.folder / "out.npz") as arrays:
            np.testing.assert_array_equal(values[:, 6], arrays["volumes"])
            np.testing.assert_array_equal(values[:, 7:], arrays["centroids"] - points)
        for row in rows:  # the fewest digits, as in Python's repr
            for text in row:
                self.assertEqual(self.digits(text), self.digits(repr(float(text))))

    @staticmethod
    def digits(text):
        return re.sub(r"e.*|[-.]", "", text).strip("0")

    CODES = "ixyzqrwpPomgEesFAaftlnvcC"

    @staticmethod
    def lists_of_faces(row):
        """Returns for each neighbor in a row with all codes the entries of its face, with coordinates of corners."""
        corners = TextOutput.brackets(row["P"])
        faces = {}
        columns = [row["n"].split(), row["e"].split(), row["a"].split(), row["f"].split(),
                   TextOutput.brackets(row["l"]),
                   [[int(v) for v in face] for face in TextOutput.brackets(row["t"])]]
        for neighbor, perimeter, size, area, normal, polygon in zip(*columns, strict=True):
            faces[int(neighbor)] = (float(perimeter), int(size), float(area), normal, [corners[v] for v in polygon])
        return faces

    @staticmethod
    def brackets(text):
        return [[float(x) for x in group.split(",")] for group in re.findall(r"\(([^)]*)\)", text)]

    def assert_same_polygon(self, mine, other):
        """Asserts the same corners in the same direction, from any start."""
        mine, other = np.array(mine), np.array(other)
        self.assertEqual(mine.shape, other.shape)
        self.assertLess(min(np.abs(np.roll(mine, k, axis=0) - other).max() for k in range(len(mine))), 2e-5)

    def voropp(self, *arguments):
        """Runs Voro++ on the file v in the unit box and returns its rows."""
        program = shutil.which("voro++")
        if not program:
            self.skipTest("no voro++")
        subprocess.run([program, *arguments, *"0 1 0 1 0 1 v".split()], cwd=self.folder, check=True,
                       capture_output=True)
        return (self.folder / "v.vol").read_text().splitlines()

    def test_against_voropp(self):
        count = 400
        rows = "".join(f"{i} {row}\n" for i, row in enumerate(text_of(random_points(count)).splitlines()))
        self.put("v", rows)
        self.put("v.txt", rows)
        form = "|".join("%" + code for code in self.CODES)
        for theirs, domain in [([], ["--list-walls"]), (["-p"], ["--periodic"]), (["-px"], ["--periodic", "x", "--list-walls"])]:
            sides = [self.rows("v.txt", *domain, "--box", "0,0,0,1,1,1", "--format", form),
                     self.voropp(*theirs, "-c", form)]
            mine, other = ({int(row[0]): dict(zip(self.CODES, row, strict=True))
                            for row in (line.split("|") for line in side)} for side in sides)
            self.assertEqual((len(mine), len(other)), (count, count))
            for i, row in mine.items():
                self.assert_same_cell(row, other[i])

    def assert_same_cell(self, row, their):
        for code in "iwsgA":
            self.assertEqual(row[code], their[code], code)
        for code in "xyzqrmEFvcC":
            np.testing.assert_allclose(np.array(row[code].split(), float), np.array(their[code].split(), float),
                                       rtol=1e-4, atol=2e-6, err_msg=code)
        for code in "pP":  # the order of vertices differs
            vertices, their_vertices = np.array(self.brackets(row[code])), np.array(self.brackets(their[code]))
            apart = np.abs(vertices[:, None] - their_vertices[None]).max(axis=2)
            self.assertLess(apart.min(axis=1).max(), 2e-5, code)
            self.assertLess(apart.min(axis=0).max(), 2e-5, code)
        self.assertEqual(sorted(row["o"].split()), sorted(their["o"].split()))
        faces, their_faces = self.lists_of_faces(row), self.lists_of_faces(their)
        self.assertEqual(list(faces), sorted(faces))
        self.assertEqual(faces.keys(), their_faces.keys())
        for neighbor, face in faces.items():
            one = their_faces[neighbor]
            self.assertEqual(face[1], one[1])
            np.testing.assert_allclose([face[0], face[2]], [one[0], one[2]], rtol=1e-4, atol=1e-5)
            if one[2] > 1e-4:  # in Voro++ those of tiny faces are noise
                np.testing.assert_allclose(face[3], one[3], atol=1e-4)
            self.assert_same_polygon(face[4], one[4])

    def test_radii_against_voropp(self):
        count = 400
        radii = 0.05 + random_points(count)[:, 2] / 50
        rows = "".join(f"{i} {row} {r!r}\n" for i, (row, r) in
                       enumerate(zip(text_of(random_points(count, 8)).splitlines(), radii.tolist())))
        self.put("v", rows)
        self.put("v.txt", rows)
        form = "%i|%r|%s|%v|%n"
        mine = self.rows("v.txt", "--radii", "5", "--list-walls", "--box", "0,0,0,1,1,1", "--format", form)
        other = {row.split("|")[0]: row.split("|") for row in self.voropp("-r", "-c", form)}
        self.assertEqual(len(other), count)
        for row in mine:
            row = row.split("|")
            their = other[row[0]]
            np.testing.assert_allclose(np.array(row[1:4], float), np.array(their[1:4], float), rtol=1e-4, atol=1e-8)
            self.assertEqual(row[4].split(), sorted(their[4].split(), key=int))

    def test_codes_of_faces(self):
        # A cube, where every code is known, with ids in another order than the rows.
        self.put("a.txt", "".join(f"{9 - i} {row}\n" for i, row in enumerate(CUBE.splitlines())))
        form = "%n|%a|%A|%e|%E|%o|%m|%g|%F|%r|%C|%P|%p|%l|%t"
        for i, text in enumerate(self.rows("a.txt", "--box", CUBE_BOX, "--format", form)):
            row = dict(zip(re.sub("[%|]", "", form), text.split("|"), strict=True))
            walls = [-5 - (i >> 2), -3 - (i >> 1 & 1), -1 - (i & 1)]
            self.assertEqual([int(j) for j in row["n"].split()], walls + sorted(9 - j for j in CUBE_NEIGHBORS[i]))
            self.assertEqual((row["a"], row["A"], row["o"]), ("4 4 4 4 4 4", "0 0 0 0 6", "3 3 3 3 3 3 3 3"))
            self.assertEqual((row["e"], row["E"], row["g"], row["F"], row["r"]),
                             ("4 4 4 4 4 4", "12", "12", "6", "0.5"))
            self.assertAlmostEqual(float(row["m"]), 0.75, places=15)
            center = np.array(CUBE.splitlines()[i].split(), float)
            np.testing.assert_allclose(np.array(row["C"].split(), float), center, atol=1e-15)
            corners = np.array(self.brackets(row["P"]))
            np.testing.assert_array_equal(corners - center, self.brackets(row["p"]))
            self.assertEqual(len(np.unique(corners, axis=0)), 8)
            np.testing.assert_array_equal(np.abs(corners - center), np.full((8, 3), 0.5))
            for neighbor, normal, polygon in zip(row["n"].split(), self.brackets(row["l"]), self.brackets(row["t"]),
                                                 strict=True):
                face = corners[[int(v) for v in polygon]] - center
                np.testing.assert_array_equal(face.mean(axis=0), np.array(normal) / 2)  # outward
                turn = np.cross(face[1] - face[0], face[2] - face[1])
                np.testing.assert_array_equal(-turn, normal)  # clockwise seen from outside, as in Voro++
                if int(neighbor) >= 0:
                    other = np.array(CUBE.splitlines()[9 - int(neighbor)].split(), float)
                    np.testing.assert_array_equal(other - center, normal)
        # A seed without a cell has empty lists and size 0.
        self.put("d.txt", "0 0 0\n1 1 1\n0 0 0\n")
        self.assertEqual(self.rows("d.txt", "--format", form)[2], "||||0||0|0|0|0.5|nan nan nan||||")

    def test_codes_of_open_faces(self):
        # Without a box faces may reach infinity, which is not a vertex.
        self.put("a.txt", text_of(random_points(40)))
        form = "%n|%a|%e|%E|%o|%g|%w|%P|%t"
        open_cells = open_faces = 0
        for text in self.rows("a.txt", "--box", "none", "--format", form):
            row = dict(zip(re.sub("[%|]", "", form), text.split("|"), strict=True))
            corners = np.array(self.brackets(row["P"])).reshape(-1, 3)
            polygons = [[int(v) for v in polygon if v != ""] for polygon in
                        (word.split(",") for word in re.findall(r"\(([^)]*)\)", row["t"]))]
            numbers = {name: row[name].split() for name in "naeo"}
            self.assertEqual(len(corners), int(row["w"]))
            self.assertEqual([int(n) for n in numbers["a"]], [len(polygon) for polygon in polygons])
            self.assertTrue(all(-1 <= v < len(corners) for polygon in polygons for v in polygon))
            edges = {frozenset((a, b)) for p in polygons for a, b in zip(p, p[1:] + p[:1]) if min(a, b) >= 0}
            around = [sum(v in p for p in polygons) for v in range(len(corners))]
            self.assertEqual([int(n) for n in numbers["o"]], around)
            ends = [sum(v in edge for edge in edges) for v in range(len(corners))]
            # Faces and edges at a vertex are equally many, and the edges that are missing are rays.
            self.assertEqual(sum(around) - sum(ends), int(row["g"]) - len(edges))
            total = 0.0
            for neighbor, polygon, length in zip(numbers["n"], polygons, numbers["e"], strict=True):
                if -1 in polygon or int(neighbor) == -1:
                    open_faces += 1
                    self.assertEqual(length, "inf")
                else:
                    expected = np.linalg.norm(corners[polygon] - np.roll(corners[polygon], 1, axis=0), axis=1).sum()
                    self.assertAlmostEqual(float(length), expected, places=9)
                total += float(length)
            np.testing.assert_allclose(float(row["E"]), total / 2)
            open_cells += row["E"] == "inf"
            self.assertEqual(row["E"] == "inf", "-1" in numbers["n"])
        self.assertGreater(open_cells, 10)
        self.assertGreater(open_faces, 3 * open_cells)
        # Cells that reach infinity are left out of meshes and pictures.
        for domain in (["--box", "none"], ["--box", "0,0,-inf,1,1,inf", "--periodic", "xy"]):
            volumes = [float(row) for row in self.rows("a.txt", *domain, "--format", "%v")]
            done = self.run_cli("a.txt", *domain, "--open", "skip", "-o", "a.vtu", "--image", "a.png")
            left_out = sum(np.isinf(volumes))
            for name in ("a.vtu", "a.png"):
                self.assertIn(f"'{name}' leaves out {left_out} cells that reach infinity", done.stderr)
            self.assertIn(f'NumberOfCells="{len(volumes) - left_out}"'.encode(), (self.folder / "a.vtu").read_bytes())
        self.put("one.txt", "0 0 0\n")
        done = self.run_cli("one.txt", "--box", "none", "--open", "skip", "-o", "a.vtu")
        self.assertIn("'a.vtu' leaves out 1 cell that reaches infinity", done.stderr)
        self.run_cli("a.txt", "-q", "--box", "none", "-o", "a.csv")
        self.assertEqual((self.folder / "a.csv").read_text().split("\n")[0], "id,x,y,z,volume,neighbors")

    def test_faces_list_walls(self):
        # Without polygons the rows list walls only by --list-walls.
        self.put("a.txt", CUBE)
        for form, walls in [("%n", False), ("%n %f %l %s %F", False), ("%n %w %p", False), ("%n %t", True),
                            ("%n %o", True)]:
            row = self.rows("a.txt", "--box", CUBE_BOX, "--format", form)[0]
            self.assertEqual(row.startswith("-5 -3 -1"), walls, form)

    def test_rows_longer_than_usual(self):
        # One seed inside a sphere of others has thousands of neighbors.
        count = 3000
        i = np.arange(count) + 0.5
        z, angle = 1 - 2 * i / count, np.pi * (1 + 5**0.5) * i
        radius = np.sqrt(1 - z * z)
        sphere = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
        self.put("a.npy", np.vstack([[0, 0, 0], sphere]))
        text = self.rows("a.npy", "--format", "%n " + "x" * 100)
        self.assertGreater(len(text[0].split()), 2000)
        self.assertEqual(len(text), count + 1)


class VoroppCommand(CliTest):
    """clvotess --voro++, compared with voro++ if it is installed."""

    def both(self, *arguments, radii=False, count=300, beyond=False, points=None):
        """Returns the rows of both programs by id, for the same command line."""
        if points is None:
            points = random_points(count, 21) * (1.2 if beyond else 1)
        columns = [points] + ([0.02 + points[:, :1] / 50] if radii else [])
        rows = [f"{i + 7} {' '.join(map(repr, row))}\n" for i, row in enumerate(np.hstack(columns).tolist())]
        self.put("pack.x", "".join(rows))
        line = [*arguments, *"0 1 0 1 0 1 pack.x".split()]
        done = self.run_cli("--voro++", *line)
        self.assertEqual((done.stdout, done.stderr), ("", ""))
        ours = (self.folder / "pack.x.vol").read_text().splitlines()
        program = shutil.which("voro++")
        if not program:
            self.skipTest("no voro++")
        (self.folder / "pack.x.vol").unlink()
        subprocess.run([program, *line], cwd=self.folder, check=True, capture_output=True)
        theirs = (self.folder / "pack.x.vol").read_text().splitlines()
        self.assertEqual([row.split()[0] for row in ours], sorted((row.split()[0] for row in theirs), key=int))
        return ours, sorted(theirs, key=lambda row: int(row.split()[0]))

    def test_default_rows(self):
        for arguments, words in [(["-o"], {}), (["-p"], {}), (["-px", "-pz", "-n", "5", "5", "5", "-m", "9"], {}),
                                 (["-r"], {"radii": True}), (["-l", "0.2"], {"beyond": True})]:
            with self.subTest(arguments):
                ours, theirs = self.both(*arguments, **words)
                for mine, other in zip(ours, theirs, strict=True):
                    self.assertEqual(len(mine.split()), len(other.split()))
                    np.testing.assert_allclose(np.array(mine.split(), float), np.array(other.split(), float), rtol=2e-5)
                    self.assertEqual(mine.split()[:4], other.split()[:4])  # six digits, as %g

    def test_walls_and_periods(self):
        """Seeds on a lower wall stay, those on an upper one are dropped; in periodic axes all are wrapped and printed there."""
        box = "0 1 0 1 0 1 walls".split()
        places = [(1.3, 0.5, 0.5), (0.75, -0.5, 0.5), (0.5, 0.9, 1.0), (0.2, 0.2, 0.0), (2.0, 0.1, 0.1), (1.0, 0.6, 0.3), (-3.75, 0.33, 0.9)]
        self.put("walls", "".join(f"{i} {x} {y} {z}\n" for i, (x, y, z) in enumerate(places)))
        for arguments, rows in [  # of voro++ 0.4.6
                (["-p"], ["0 0.3 0.5 0.5 0.3 0.5 0.5", "1 0.75 0.5 0.5 0.75 0.5 0.5", "2 0.5 0.9 0 0.5 0.9 0", "3 0.2 0.2 0 0.2 0.2 0",
                          "4 0 0.1 0.1 0 0.1 0.1", "5 0 0.6 0.3 0 0.6 0.3", "6 0.25 0.33 0.9 0.25 0.33 0.9"]),
                (["-px"], ["0 0.3 0.5 0.5 0.3 0.5 0.5", "3 0.2 0.2 0 0.2 0.2 0", "4 0 0.1 0.1 0 0.1 0.1", "5 0 0.6 0.3 0 0.6 0.3",
                           "6 0.25 0.33 0.9 0.25 0.33 0.9"]),
                (["-py", "-pz"], ["1 0.75 0.5 0.5 0.75 0.5 0.5", "2 0.5 0.9 0 0.5 0.9 0", "3 0.2 0.2 0 0.2 0.2 0"]),
                ([], ["3 0.2 0.2 0 0.2 0.2 0"])]:
            self.run_cli("--voro++", *arguments, "-c", "%i %q %x %y %z", *box)
            self.assertEqual((self.folder / "walls.vol").read_text().splitlines(), rows, arguments)
        rng = np.random.default_rng(8)
        for arguments in [["-p"], ["-px"], ["-pz", "-py"], []]:
            points = np.round(random_points(300, 8) * 256) / 256 + rng.integers(0, 3, (300, 3)) - (rng.random((300, 3)) < 0.2) / 3
            inside = rng.random(300) < 0.5
            points[inside] = np.round(random_points(300, 9)[inside] * 16) / 16  # many on walls
            points = np.unique(points, axis=0)
            places = points % 1
            _, kept = np.unique(places, axis=0, return_index=True)  # voro++ fails at equal seeds
            ours, theirs = self.both(*arguments, "-c", "%i %q %x %y %z %v %C", points=points[kept])
            self.assertEqual([row.split()[:7] for row in ours], [row.split()[:7] for row in theirs], arguments)
            one, other = (np.array([row.split() for row in rows], float) for rows in (ours, theirs))
            np.testing.assert_allclose(one, other, rtol=2e-5, atol=2e-5)

    def test_neighbors_and_walls(self):
        for arguments in [["-p"], ["-r", "-py"]]:
            with self.subTest(arguments):
                ours, theirs = self.both(*arguments, "-c", "%i %s %n", radii="-r" in arguments)
                for mine, other in zip(ours, theirs, strict=True):
                    self.assertEqual(mine.split()[:2] + sorted(mine.split()[2:]),
                                     other.split()[:2] + sorted(other.split()[2:]))

    def test_refused(self):
        self.put("a", "0 0.5 0.5 0.5\n")
        box = "0 1 0 1 0 1".split()
        for arguments, says in [([], "needs a value"), (["-p"], "needs a value"), ([*box], ["x_min", "6 words"]),
                                (["-g", *box, "a"], "gnuplot"), (["-ws", "0", "0", "0", "1", *box, "a"], "--wall-sphere"),
                                (["-z", *box, "a"], "'-z'"), (["-n", "3", "x", "3", *box, "a"], ["-n", "'x'"]),
                                ([*box, "b"], "b"), ([*box, "a", "more"], "8 words"), (["-c", "%k", *box, "a"], "%k"),
                                (["-c"], "-c"), (["0", "1", "0", "y", "0", "1", "a"], "'y'")]:
            with self.subTest(arguments):
                self.refuse("--voro++", *arguments, says=says)
        self.run_cli("--voro++", "-v", *box, "a")
        self.assertEqual((self.folder / "a.vol").read_text(), "0 0.5 0.5 0.5 1\n")


class ArrayOutput(CliTest):
    def load(self, *arguments):
        self.run_cli(*arguments, "-o", "out.npz")
        with np.load(self.folder / "out.npz", allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def test_arrays(self):
        count = 2000
        arrays = self.load("--random", count, "--want", "neighbors,volumes,centroids")
        self.assertEqual({name: (array.dtype.str, array.shape[1:]) for name, array in arrays.items()},
                         {"indptr": ("<i8", ()), "indices": ("<i4", ()), "volumes": ("<f8", ()),
                          "centroids": ("<f8", (3,)), "status": ("|u1", ()), "box": ("<f8", (3,)),
                          "periodic": ("|u1", ()), "version": ("<U5", ()), "domain_from": ("<U6", ()),
                          "periodic_from": ("<U7", ())})
        indptr, indices = arrays["indptr"], arrays["indices"]
        self.assertEqual((len(indptr), indptr[0], indptr[-1]), (count + 1, 0, len(indices)))
        for name in ["volumes", "centroids", "status"]:
            self.assertEqual(len(arrays[name]), count)
        self.assertAlmostEqual(arrays["volumes"].sum(), 1, places=12)
        np.testing.assert_allclose(arrays["volumes"] @ arrays["centroids"], [0.5] * 3, rtol=1e-12)
        rows = [set(indices[indptr[i]:indptr[i + 1]].tolist()) for i in range(count)]
        self.assertTrue(all(i in rows[j] for i, row in enumerate(rows) for j in row))
        text = [[int(j) for j in row.split()] for row in self.rows("--random", count, "--format", "%n")]
        self.assertEqual(sum(text, []), indices.tolist())

    def test_only_what_is_wanted(self):
        """By the table of arrays: a group, and each of its arrays, brings the group and those that it needs."""
        needs = {"areas": ["neighbors"], "normals": ["neighbors"], "vertices": ["neighbors"], "faces": ["vertices", "neighbors"]}
        groups, arrays = read_table()

        def names(*of):
            return [array.name for array in arrays if not array.optional and array.group in ("", *of)]

        domain = ["box", "periodic", "version", "domain_from", "periodic_from"]
        self.assertEqual(sorted(self.load("--random", "50")), sorted([*names("neighbors", "volumes"), *domain]))
        for group, _ in groups:
            for want in {group, *names(group)}:
                of = [group, *needs.get(group, ())] if want not in names() else []
                self.assertEqual(sorted(self.load("--random", "50", "--want", want)), sorted([*names(*of), *domain]), want)
        self.assertEqual(sorted(self.load("--random", "50", "--want=centroids, volumes")),
                         sorted([*names("volumes", "centroids"), *domain]))

    def test_every_array(self):
        """.npz has each array of the table with its type and shape, .csv and .vtu have each that has a column."""
        groups, table = read_table()
        count = 300
        self.run_cli("--random", count, "--want", ",".join(group for group, _ in groups), "-o", "a.npz", "-o", "a.csv", "-o", "a.vtu")
        with np.load(self.folder / "a.npz") as arrays, open(self.folder / "a.csv") as csv:
            header = csv.readline().strip().split(",")
            rows = np.loadtxt(csv, delimiter=",")
            lengths = {"cell": count, "entry": arrays["indptr"][-1], "vertex": len(arrays["vertices"])}
            for array in table:
                if array.optional:
                    continue
                values = arrays[array.name]
                self.assertEqual(values.dtype, np.dtype(array.python_type()[:-5].lower()), array.name)
                if array.per != "other":
                    self.assertEqual(values.shape, (lengths[array.per], 3)[: values.ndim], array.name)
                    self.assertEqual(values.ndim, 2 if array.components > 1 else 1, array.name)
                self.assertIn(f"`{array.name}`", (ROOT / "bindings/python/docs/pages/files.md").read_text())
                if array.column:
                    columns = [f"{array.column}_{axis}" for axis in "xyz"] if array.components > 1 else [array.column]
                    np.testing.assert_array_equal(rows[:, [header.index(name) for name in columns]].reshape(values.shape), values)
                    self.assertIn(b'Name="%s"' % array.column.encode(), (self.folder / "a.vtu").read_bytes())
                    if array.components == 1:
                        self.refuse("a.csv", "--copy", array.column, "-o", "b.vtu", says="array of that name")
        whole_help = self.run_cli("--help-all").stdout
        for array in table:
            self.assertTrue(array.group == "" or array.name in whole_help, array.name)

    def test_text_adds_what_it_needs(self):
        self.run_cli("--random", "50", "--want", "volumes", "-o", "cells.txt", "--format", "%n %c %w")
        self.assertEqual(len((self.folder / "cells.txt").read_text().splitlines()), 50)

    def test_archive_is_sound_and_repeatable(self):
        self.load("--random", "1000")
        with zipfile.ZipFile(self.folder / "out.npz") as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual({info.compress_type for info in archive.infolist()}, {zipfile.ZIP_STORED})
        first = (self.folder / "out.npz").read_bytes()
        self.load("--random", "1000", "-t", "1")
        with np.load(io.BytesIO(first)) as old, np.load(self.folder / "out.npz") as new:
            np.testing.assert_array_equal(old["indices"], new["indices"])
        unzip = shutil.which("unzip")
        if unzip:
            subprocess.run([unzip, "-tq", str(self.folder / "out.npz")], check=True, capture_output=True)

    def test_zip64(self):
        """Runs the code with a limit of 100 bytes instead of 4 GiB, so that every kind of record occurs."""
        compiler = shutil.which(os.environ.get("CXX", "c++"))
        if not compiler:
            self.skipTest("no compiler")
        # One file of source, because most of the time goes into headers.
        sources = ["cli/files/formats/zip_writer.cpp", "cli/files/output_file.cpp", "cli/files/numbers.cpp", "engine/core/system.cpp"]
        self.put("driver.cpp", "".join(f'#include "{ROOT / name}"\n' for name in sources) + """
            #include <array>
            int main() {
                const std::string small(99, 's'), large(100, 'l');
                clvotess::OutputFile file("out.npz");
                clvotess::ZipWriter zip(file, 100);
                zip.add("small", std::array<std::string_view, 2>{small, ""});
                zip.add("large", std::array<std::string_view, 2>{large, large});
                zip.add("later", std::array<std::string_view, 1>{small});
                zip.finish();
                file.finish();
                file.publish();
            }""")
        subprocess.run([compiler, "-std=c++20", f"-I{ROOT / 'cli'}", f"-I{ROOT / 'engine'}", "driver.cpp", "-lz", "-o", "driver"],
                       cwd=self.folder, check=True)
        subprocess.run(["./driver"], cwd=self.folder, check=True)
        content = (self.folder / "out.npz").read_bytes()
        self.assertEqual(content.count(b"PK\x06\x06"), 1)
        # The local header of "large", which zipfile and numpy.load do not read.
        at = 30 + len("small") + 99
        fields = struct.unpack_from("<IHHHHHIIIHH5sHHQQ", content, at)
        self.assertEqual((fields[0], fields[1], *fields[7:]),
                         (0x04034B50, 45, 2**32 - 1, 2**32 - 1, 5, 20, b"large", 1, 16, 200, 200))
        with zipfile.ZipFile(self.folder / "out.npz") as archive:
            self.assertIsNone(archive.testzip())
            self.assertEqual([archive.read(name) for name in ["small", "large", "later"]],
                             [b"s" * 99, b"l" * 200, b"s" * 99])
        unzip = shutil.which("unzip")
        if unzip:
            subprocess.run([unzip, "-tq", str(self.folder / "out.npz")], check=True, capture_output=True)
