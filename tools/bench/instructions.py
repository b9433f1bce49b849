#!/usr/bin/env python3
"""Counts the instructions that clvotess executes for each cell, on nine kinds of input, with Valgrind's callgrind.

    instructions.py [--clvotess build/release/bin/clvotess] [--galaxies FILE.xyz] [--only NAME,..] [--json FILE]

A count does not depend on how busy or fast a machine is. One thread runs. The count of 1,000 seeds of the same kind is
subtracted, and so is the start of the program. Valgrind has no AVX-512, so the AVX2 path is counted.
Inputs are .npy and .npz files, the same on every machine. Needs valgrind and nothing else beside Python.
Exit codes: 0 every row is at most its goal, 1 some row is not, 2 usage, or something could not be run.
"""

import argparse
import array
import concurrent.futures
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import zipfile

SMALL = 1000  # seeds whose cost is taken off
TILTS = [1, 0, 0, 0.4, 1, 0, -0.3, 0.2, 1]


def uniform(count, generator):
    return [generator.random() for _ in range(3 * count)]


def clusters(count, generator):
    """50 normal clusters in the unit box, sigma from 0.01 to 0.05; seeds outside come back in on the other side."""
    homes = [([generator.random() for _ in range(3)], 0.01 + 0.04 * generator.random()) for _ in range(50)]
    points = []
    for _ in range(count):
        center, sigma = generator.choice(homes)
        points += [generator.gauss(x, sigma) % 1 for x in center]
    return points


def wall_across_a_corner(count, generator):
    points = []
    while len(points) < 3 * count:
        p = [generator.random() for _ in range(3)]
        if sum(p) <= 2.5:
            points += p
    return points


BOX = ["--box", "0,0,0,1,1,1"]
CELL = ["--cell", ",".join(map(str, TILTS))]
LISTS = ["--want", "neighbors"]
GEOMETRY = ["--want", "neighbors,volumes,centroids,areas"]

# name, seeds, points, radii up to this many mean spacings, options, goal
ROWS = [
    ("uniform", 50_000, uniform, 0, BOX + LISTS, 11_000),
    ("uniform, geometry", 50_000, uniform, 0, BOX + GEOMETRY, 14_500),
    ("periodic box", 50_000, uniform, 0, BOX + ["--periodic"] + LISTS, 13_000),
    ("triclinic box", 50_000, uniform, 0, CELL + LISTS, 16_000),
    ("one wall", 50_000, wall_across_a_corner, 0, BOX + ["--wall", "1,1,1,2.5"] + LISTS, 14_000),
    ("radii", 50_000, uniform, 0.737, BOX + ["--radii", "radii"] + LISTS, 20_000),
    ("faces", 50_000, uniform, 0, BOX + ["--want", "faces"], 30_000),
    ("galaxies", None, None, 0, LISTS, 17_000),
    ("50 clusters", 100_000, clusters, 0, BOX + LISTS, 15_000),
]


def npy(values, shape):
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}".ljust(117).encode() + b"\n"
    numbers = array.array("d", values)
    if sys.byteorder == "big":
        numbers.byteswap()
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + numbers.tobytes()


def write_input(path, points, radii):
    count = len(points) // 3
    if not radii:
        path.write_bytes(npy(points, (count, 3)))
        return
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("points.npy", npy(points, (count, 3)))
        archive.writestr("radii.npy", npy(radii, (count,)))


def make_input(folder, row, count, galaxies):
    name, full, points_of, spread, _, _ = row
    generator = random.Random(f"{name} {count}")
    points = points_of(count, generator) if points_of else galaxies[: 3 * count]
    largest = spread * count ** (-1 / 3)
    radii = [largest * generator.random() for _ in range(count)] if spread else []
    path = folder / f"{name.replace(' ', '_')}_{count}.{'npz' if radii else 'npy'}"
    write_input(path, points, radii)
    return path


def count_instructions(program, path, options):
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={path}.out", str(program), str(path),
               "--device", "cpu", "--threads", "1", "--quiet", *options]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    collected = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not collected:
        sys.exit(f"instructions: {' '.join(command)} failed:\n{done.stderr}")
    return int(collected.group(1))


def read_galaxies(path):
    with open(path, encoding="ascii") as lines:
        return [float(x) for line in lines if line.strip() and not line.startswith("#") for x in line.split()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    root = pathlib.Path(__file__).resolve().parents[2]
    parser.add_argument("--clvotess", type=pathlib.Path, default=root / "build/release/bin/clvotess")
    parser.add_argument("--galaxies", type=pathlib.Path, help="text rows x y z; without it that row is left out")
    parser.add_argument("--only", help="rows with one of these beginnings, with commas between them")
    parser.add_argument("--json", type=pathlib.Path, help="write the counts there too")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()

    galaxies = read_galaxies(arguments.galaxies) if arguments.galaxies else []
    rows = [row for row in ROWS if row[2] or galaxies]
    if arguments.only:
        rows = [row for row in rows if row[0].startswith(tuple(arguments.only.split(",")))]

    def measure(row):
        full = row[1] or len(galaxies) // 3
        counts = [count_instructions(arguments.clvotess, make_input(folder, row, count, galaxies), row[4])
                  for count in (full, SMALL)]
        return (counts[0] - counts[1]) / (full - SMALL)

    with tempfile.TemporaryDirectory() as name, concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        folder = pathlib.Path(name)
        counts = list(pool.map(measure, rows))
    print(f"{'input':20} {'instructions per cell':>22} {'goal':>8}")
    for row, count in zip(rows, counts):
        print(f"{row[0]:20} {count:22,.0f} {row[5]:8,}{'' if count <= row[5] else '  missed'}")
    if arguments.json:
        arguments.json.write_text(json.dumps({row[0]: round(count) for row, count in zip(rows, counts)}, indent=1) + "\n")
    return 0 if all(count <= row[5] for row, count in zip(rows, counts)) else 1


if __name__ == "__main__":
    sys.exit(main())
