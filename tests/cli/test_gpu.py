"""clvotess on Vulkan devices: the choice of -x, and equal files for all devices.

These tests run under the validation layer, which finds misuse of Vulkan.
"""

import os
import re
import shutil
import sys
import unittest

import numpy as np

from cli_test import CLI, HIDDEN, CliTest, random_points, text_of

__all__ = ["Devices"]


class Devices(CliTest):
    def environment(self, **more):
        return {**os.environ, **more}

    def has_lavapipe(self):
        return any(re.match(r"\d+ .*software", line) for line in self.run_cli("--list-devices").stdout.splitlines())

    def test_list(self):
        lines = self.run_cli("--list-devices").stdout.splitlines()
        self.assertRegex(lines[0], r"^device +name +description$")
        self.assertRegex(lines[1], r"^cpu +CPU +\d+ thread")
        for index, line in enumerate(lines[2:]):
            self.assertRegex(line, rf"^{index} +\S.*Vulkan \d.*storage buffers to .*subgroups of \d+.* make cells.*, measured in ")
        for line, device in zip(lines[1:], self.json("--list-devices")):
            self.assertEqual(line.split(), " ".join(device[key] for key in lines[0].split()).split())
        self.assertTrue(self.has_lavapipe(), "the tests need Mesa's lavapipe")

    def test_no_driver(self):
        self.put("a.txt", text_of(random_points(50)))
        hidden = self.environment(**HIDDEN)
        self.assertEqual(len(self.run_cli("--list-devices", env=hidden).stdout.splitlines()), 2)
        self.assertEqual(self.json("--random", 10000, "-x", "auto", env=hidden)["device"], "cpu")
        self.assertEqual(self.json("a.txt", env=hidden)["device"], "cpu")
        for device in ["gpu", "lavapipe", "0"]:
            done = self.run_cli("a.txt", "-x", device, "-o", "b.txt", env=hidden, code=2)
            self.assertEqual(done.stderr, f"clvotess: device '{device}' is not available: no Vulkan driver on this machine\n")
        self.assertEqual(self.files(), ["a.txt"])

    def test_few_points_look_for_no_gpu(self):
        for points, looks in ((9999, False), (10000, True)):
            done = self.run_cli("--random", points, "-q", env=self.environment(LD_DEBUG="files"))
            self.assertEqual("libvulkan" in done.stderr, looks)

    def test_no_such_device(self):
        self.put("a.txt", text_of(random_points(50)))
        self.refuse("a.txt", "-x", "999", "-o", "b.txt", says=["device '999' is not available", "0 to "])
        listed = self.run_cli("--list-devices").stdout
        if "GPU," not in listed:
            self.refuse("a.txt", "-x", "gpu", "-o", "b.txt", says=["device 'gpu' is not available: no Vulkan device is a GPU"])
            self.assertEqual(self.json("a.txt")["device"], "cpu")

    def test_summary(self):
        result = self.json("--random", 2000, "-x", "lavapipe", "--verify")
        self.assertTrue(result["verified"])
        self.assertIn("llvmpipe", result["device"])
        self.assertLessEqual(result["fallback_cells"], 100)  # 65: no second tier
        self.assertEqual(list(result["fallback_reasons"]), ["uncertain", "overflow", "exhausted", "skipped", "domain"])
        self.assertEqual(sum(result["fallback_reasons"].values()), result["fallback_cells"])
        self.assertAlmostEqual(result["volume_sum"], 1, delta=1e-5)
        seconds = result["seconds"]
        for stage in ["open", "upload", "sort", "knn", "clip", "download"]:
            self.assertGreater(seconds[stage], 0, stage)
        self.assertGreater(seconds["open"], seconds["upload"])
        self.assertEqual(self.json("--random", 2000, "-x", "cpu")["seconds"]["open"], 0)
        stages = sum(value for name, value in seconds.items() if name != "total")
        # A busy machine loses time between stages, so the bounds only distinguish seconds from other units.
        self.assertLess(stages, 2 * seconds["total"])
        self.assertGreater(stages, 0.1 * seconds["total"])

    def test_same_files(self):
        """The options reach the device. Tests in C++ compare all kinds of inputs."""
        uniform = random_points(1500)
        self.put("in.npy", np.concatenate([uniform, uniform[:200]]))
        for chosen in [["-k", 8], ["-k", 200], ["--chunk-size", 1000], ["--list-walls", "--precision", "double"]]:
            with self.subTest(options=chosen):
                self.run_cli("in.npy", "-x", "lavapipe", "-q", "-o", "gpu.txt", *chosen)
                self.run_cli("in.npy", "-x", "cpu", "-q", "-o", "cpu.txt", *chosen)
                self.assertTrue((self.folder / "gpu.txt").read_bytes() == (self.folder / "cpu.txt").read_bytes())

    def test_volumes(self):
        for precision, tolerance in [("single", 1e-5), ("double", 1e-10)]:
            volumes = []
            for device in ["cpu", "lavapipe"]:
                self.run_cli("--random", 1000, "-x", device, "--precision", precision, "-q", "-o", "v.npz")
                with np.load(self.folder / "v.npz") as arrays:
                    volumes.append(arrays["volumes"])
            self.assertLessEqual(np.max(np.abs(volumes[1] / volumes[0] - 1)), tolerance)

    def test_cache_directory(self):
        folder = self.folder / "cache"
        self.run_cli("--random", 100, "-x", "lavapipe", "-q", env=self.environment(VOTESS_CACHE_DIR=str(folder)))
        self.assertEqual(len(list(folder.iterdir())), 1)
        for chosen, made in [({}, True), ({"VOTESS_CACHE_DIR": ""}, False)]:
            environment = self.environment(XDG_CACHE_HOME=str(self.folder / "xdg"), **chosen)
            if not chosen:
                environment.pop("VOTESS_CACHE_DIR", None)
            self.run_cli("--random", 100, "-x", "lavapipe", "-q", env=environment)
            self.assertEqual((self.folder / "xdg" / "votess").exists(), made)
            shutil.rmtree(self.folder / "xdg" / "votess", ignore_errors=True)


if __name__ == "__main__":
    if not shutil.which(CLI):
        sys.exit(f"VOTESS_CLI must name clvotess, but there is no {CLI}")
    unittest.main(verbosity=2)
