#!/usr/bin/env python3
"""Measures queries of votess and other packages: the same points, one thread each, in turns.

    queries.py [--seeds 1e6] [--queries 1e6] [--probed 1e5] [--probes 1e5] [--ghosts 1e5] [--repeats 3]

Points are uniform in the unit box. Diagram.locate() and SciPy's cKDTree find the cells of `queries` among `seeds`.
Diagram.probe(), with neighbors and volumes, and ghost_cells() of pyvoro2 find the cells of `probes` among `probed`.
ghost_cells() makes a dict for each cell and gets `ghosts` of the queries. It reads the seeds again in each call, so the
time of a call with one query is subtracted. Prints the median of the repeats and whether the answers agree. Missing
packages are skipped; pyvotess must be importable.
"""

import argparse
import importlib.util
import statistics
import time

import numpy as np

import pyvotess as vt

BOX = ((0, 1), (0, 1), (0, 1))


def seconds_of(call):
    began = time.perf_counter()
    answer = call()
    return time.perf_counter() - began, answer


def take_turns(calls, repeats):
    """The seconds of each call in each repeat, and its last answer, by name."""
    seconds, answers = {name: [] for name in calls}, {}
    for _ in range(repeats):
        for name, call in calls.items():
            taken, answers[name] = seconds_of(call)
            seconds[name].append(taken)
    return seconds, answers


def rows_of(seconds, counts):
    """(name, queries, median of the seconds for each of them) of the names that have a count."""
    return [(name, count, statistics.median(seconds[name]) / count) for name, count in counts.items()]


def locate(generator, arguments):
    points, queries = generator.random((arguments.seeds, 3)), generator.random((arguments.queries, 3))
    sorting, diagram = seconds_of(lambda: vt.Diagram(points, box=BOX, threads=1))
    print(f"\nwhich of {len(points):,} cells: Diagram() {sorting:.3f} s", end="")
    calls = {"votess locate": lambda: diagram.locate(queries)}
    if importlib.util.find_spec("scipy"):
        from scipy.spatial import cKDTree

        sorting, tree = seconds_of(lambda: cKDTree(points))
        print(f", cKDTree() {sorting:.2f} s", end="")
        calls["scipy cKDTree.query"] = lambda: tree.query(queries, workers=1)[1]
    print()
    seconds, answers = take_turns(calls, arguments.repeats)
    if len(answers) == 2:
        ours, theirs = answers.values()
        print(f"    {np.count_nonzero(ours != theirs)} answers differ")
    return rows_of(seconds, dict.fromkeys(calls, len(queries)))


def probe(generator, arguments):
    points, queries = generator.random((arguments.probed, 3)), generator.random((arguments.probes, 3))
    sorting, diagram = seconds_of(lambda: vt.Diagram(points, box=BOX, threads=1))
    print(f"\nwhat cells among {len(points):,}: Diagram() {sorting:.3f} s", end="")
    calls = {"votess probe": lambda: diagram.probe(queries)}
    counts = {"votess probe": len(queries)}
    if importlib.util.find_spec("pyvoro2"):
        import pyvoro2

        def ghosts(count):
            return pyvoro2.ghost_cells(points, queries[:count], domain=pyvoro2.Box(BOX), return_vertices=False,
                                       return_adjacency=False)

        calls["one ghost"] = lambda: ghosts(1)
        calls["pyvoro2 ghost_cells"] = lambda: ghosts(arguments.ghosts)
        counts["pyvoro2 ghost_cells"] = arguments.ghosts - 1
    seconds, answers = take_turns(calls, arguments.repeats)
    if len(calls) > 1:
        alone = statistics.median(seconds["one ghost"])
        print(f", a call of ghost_cells() with one query {alone:.2f} s", end="")
        seconds["pyvoro2 ghost_cells"] = [taken - alone for taken in seconds["pyvoro2 ghost_cells"]]
        probes, cells = answers["votess probe"], answers["pyvoro2 ghost_cells"]
        rows = [{face["adjacent_cell"] for face in cell["faces"] if face["adjacent_cell"] >= 0} for cell in cells]
        differ = sum(row != set(probes.neighbors[q].tolist()) for q, row in enumerate(rows))
        volumes = np.array([cell["volume"] for cell in cells])
        error = np.abs(volumes / probes.volumes[: len(cells)] - 1).max()
        print(f"\n    {differ} of {len(cells)} rows differ, volumes by at most {error:.1e}", end="")
    print()
    return rows_of(seconds, counts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, default in (("seeds", "1e6"), ("queries", "1e6"), ("probed", "1e5"), ("probes", "1e5"), ("ghosts", "1e5")):
        parser.add_argument(f"--{name}", type=lambda text: int(float(text)), default=default)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    if arguments.ghosts < 2 or arguments.ghosts > arguments.probes:
        parser.error("--ghosts must be from 2 to --probes")
    generator = np.random.default_rng(1)
    for ask in (locate, probe):
        rows = ask(generator, arguments)
        for name, queries, each in rows:
            print(f"    {name:20} {1e6 * each:8.2f} us a query, {1e-3 / each:7.1f} thousand a second ({queries:,} queries)")
        if len(rows) == 2:
            print(f"    votess is {rows[1][2] / rows[0][2]:.2f} times as fast")


if __name__ == "__main__":
    main()
