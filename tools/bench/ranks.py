#!/usr/bin/env python3
"""Measures a run over ranks: cells a CPU second, bytes sent a cell, seeds given and needed.

mpirun -np P python3 ranks.py KIND N [N ...]    KIND: uniform or clusters (50 of them)

One thread a rank; neighbors and volumes in the unit box; each rank hands in seeds from all over it. The CPU seconds are
those of all ranks; a rank that waits polls for messages, which counts too.
"""

import argparse
import time

import numpy as np
import pyvotess.mpi
from mpi4py import MPI


def seeds(kind, count, rank):
    random = np.random.default_rng(5 + rank)
    if kind == "uniform":
        return random.random((count, 3))
    centers = np.random.default_rng(1).random((50, 3))
    return np.clip(centers[random.integers(0, 50, count)] + 0.01 * random.standard_normal((count, 3)), 0, 1)


def main():
    world = MPI.COMM_WORLD
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=("uniform", "clusters"))
    parser.add_argument("count", type=float, nargs="+")
    arguments = parser.parse_args()
    for count in arguments.count:
        own = seeds(arguments.kind, int(count) // world.size, world.rank)
        world.Barrier()
        cpu, wall = time.process_time(), time.perf_counter()
        counts = pyvotess.mpi.tessellate(own, world, box=(0, 0, 0, 1, 1, 1), threads=1).counts
        cpu = world.reduce(time.process_time() - cpu)
        if world.rank == 0:
            print(
                f"{arguments.kind} {counts.seeds}, {world.size} ranks: {counts.seeds / cpu:.0f} cells a CPU second, "
                f"{time.perf_counter() - wall:.2f} s, {counts.bytes / counts.seeds:.0f} bytes sent a cell, "
                f"{counts.given} seeds given, {counts.needed} needed, {counts.questions} cells asked about"
            )


main()
