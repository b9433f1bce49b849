"""--volumes: weights that give each cell its volume."""

import json

import numpy as np

from cli_test import CliTest, random_points

BOX = ("--box", "0,0,0,1,1,1")


class Volumes(CliTest):
    def put_grains(self, count=200, scale=1.0):
        """Writes grains.csv. Returns the volumes in it."""
        points = random_points(count)
        volumes = np.exp(np.random.default_rng(2).normal(0, 0.6, count))
        volumes *= scale / volumes.sum()
        rows = [",".join(repr(float(v)) for v in row) for row in np.column_stack((points, volumes))]
        self.put("grains.csv", "x,y,z,volume\n" + "\n".join(rows) + "\n")
        return volumes

    def test_file_has_the_weights(self):
        volumes = self.put_grains()
        summary = json.loads(self.run_cli("grains.csv", "--volumes", "volume", *BOX, "--periodic", "--copy", "volume",
                                          "-o", "grains.npz", "--json", "--verify").stdout)
        self.assertLess(summary["fit"]["residual"], 1e-9)
        self.assertGreater(summary["fit"]["steps"], 1)
        self.assertIs(summary["verified"], True)
        written = np.load(self.folder / "grains.npz")
        self.assertLess(np.abs(written["volumes"] / volumes - 1).max(), 1.001e-9)
        self.assertListEqual(list(written["volume"]), list(volumes))
        # Another run reads the weights from the file.
        table = np.column_stack((random_points(200), written["weights"]))
        self.put("again.txt", "".join(" ".join(map(repr, map(float, row))) + "\n" for row in table))
        self.run_cli("again.txt", "--weights", 4, *BOX, "--periodic", "-o", "again.npz", "-t", 1)
        again = np.load(self.folder / "again.npz")
        self.assertLess(np.abs(again["volumes"] / volumes - 1).max(), 1.001e-9)
        self.assertListEqual(list(again["indices"]), list(written["indices"]))

    def test_shares_start_and_tolerance(self):
        volumes = self.put_grains(scale=5)
        says = self.run_cli("grains.csv", "--volumes", "volume", *BOX, code=2).stderr
        self.assertRegex(says, r"sum to (5|4\.99)\S*, but the domain has 1: .*normalize")
        fitted = self.run_cli("grains.csv", "--volumes", "volume", *BOX, "--normalize", "--tolerance", "1e-2", "-o",
                              "rough.npz")
        self.assertRegex(fitted.stdout, r"fit +\d+ steps, largest error of a volume \d\.\de-\d\d of its target")
        written = np.load(self.folder / "rough.npz")
        self.assertLess(np.abs(written["volumes"] * 5 / volumes - 1).max(), 1.001e-2)
        table = np.column_stack((random_points(200), volumes, written["weights"]))
        self.put("on.csv", "x,y,z,v,w\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in table))
        rest = json.loads(self.run_cli("on.csv", "--volumes", "v", "--weights", "w", *BOX, "--normalize", "--json").stdout)
        self.assertLessEqual(rest["fit"]["steps"], 3)
        self.assertLess(rest["fit"]["residual"], 1e-9)

    def test_in_a_mesh(self):
        """Cells in a tetrahedron, also where the box repeats."""
        self.put("a.off", "OFF\n4 4 6\n0 0 0\n2 0 0\n0 2 0\n0 0 2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n")
        points = 0.6 * random_points(40)
        shares = np.linspace(1, 2, 40)
        rows = [",".join(map(repr, map(float, row))) for row in np.column_stack((points, shares))]
        self.put("in.csv", "x,y,z,share\n" + "\n".join(rows) + "\n")
        for more in ((), ("--box", "0,0,0,3,3,3", "--periodic")):
            self.run_cli("in.csv", "--mesh", "a.off", "--volumes", "share", "--normalize", *more, "-o", "out.npz", "-q")
            written = np.load(self.folder / "out.npz")
            self.assertLess(np.abs(written["volumes"] / (shares / shares.sum() * 8 / 6) - 1).max(), 1.001e-9)

    def test_refused(self):
        self.put_grains()
        volumes = ("grains.csv", "--volumes", "volume", *BOX)
        for arguments, says, code in [
            ((*volumes, "--max-steps", 1, "-o", "x.npz"), "after 1 steps .*raise --max-steps", 1),
            ((*volumes, "--tolerance", "0"), "--tolerance is 0: it must be positive", 2),
            ((*volumes, "--tolerance", "x"), "--tolerance must be|is not a number", 2),
            (("grains.csv", "--volumes", "mass", *BOX), "no column .mass.", 2),
            (("grains.csv", "--volumes", "x", *BOX), "sum to", 2),
            (("grains.csv", *BOX, "--tolerance", "1e-6"), "--tolerance goes with --volumes", 2),
            (("grains.csv", *BOX, "--normalize"), "--normalize goes with --volumes", 2),
            (("--random", 10, "--volumes", 1), "--volumes goes with INPUT", 2),
            ((*volumes, "--locate", "grains.csv", "-o", "x.npy"), "--volumes is for cells", 2),
        ]:
            with self.subTest(arguments=arguments):
                self.assertRegex(self.run_cli(*arguments, code=code).stderr, says)
                self.assertListEqual(self.files(), ["grains.csv"])
