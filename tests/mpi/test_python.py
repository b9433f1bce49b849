"""pyvotess.mpi against pyvotess on one rank. Run by mpirun; the first difference ends all ranks."""

import sys
import traceback

import numpy as np
import pyvotess
import pyvotess.mpi
from mpi4py import MPI

WORLD = MPI.COMM_WORLD


def check(good, what):
    if not good:
        raise AssertionError(what)


def share(comm, count):
    """Which of the seeds are this rank's: the first rank has none where there are more."""
    owner = np.random.default_rng(7).integers(min(1, comm.size - 1), comm.size, count)
    return np.flatnonzero(owner == comm.rank), owner


def same_rows(t, alone, ids):
    for row, seed in enumerate(ids):
        check(np.array_equal(t.neighbors[row], alone.neighbors[seed]), f"row of {seed}")


def with_one_machine(comm, points, want="volumes,centroids,areas,normals,counts,surfaces,radii", each=None, **options):
    mine, owner = share(comm, len(points))
    each = each or {}
    alone = pyvotess.tessellate(points, want=want, device="cpu", **options, **each)
    own = {name: values[mine] for name, values in each.items()}
    t = pyvotess.mpi.tessellate(points[mine], comm, ids=mine, want=want, **options, **own)
    check(np.array_equal(t.ids, mine) and t.points is None, "ids")
    same_rows(t, alone, mine)
    check(np.array_equal(t.status, alone.status[mine]), "status")
    rows = t.neighbors.indices
    check(np.array_equal(t.owners, np.where(rows < 0, -1, owner[np.maximum(rows, 0)])), "owners")
    entries = np.concatenate([np.arange(*alone.neighbors.indptr[i : i + 2]) for i in mine] or [np.empty(0, int)])
    if alone.shifts is not None and len(mine):
        check(np.array_equal(t.shifts, alone.shifts[entries]), "shifts")
    for name in ("volumes", "centroids", "surface_areas", "security_radii", "face_counts", "edge_counts"):
        check(np.allclose(getattr(t, name), getattr(alone, name)[mine], rtol=1e-9, atol=1e-12), name)
    check(np.allclose(t.face_areas, alone.face_areas[entries], rtol=1e-9, atol=1e-12), "face_areas")
    check(np.allclose(t.face_normals, alone.face_normals[entries], atol=1e-6), "face_normals")
    report = t.verify(comm, points[mine], sample=50)
    check(report and not report.skipped and report.sampled == min(50, len(points)), f"{report}")
    check(t.counts.seeds == len(points) and np.isclose(t.counts.volume_sum, t.counts.box_volume), "counts")

    check(np.array_equal(t.box, alone.box) if "cell" not in options else t.box is None, "box")

    # What one sends the other receives.
    for rank, sent in enumerate(comm.alltoall(list(t.send))):
        check(np.array_equal(sent, t.receive[rank]), f"lists of rank {rank}")

    made = pyvotess.mpi.tessellate(points[mine], comm, ids=mine, want="neighbors", cells="made", **options, **own)
    same_rows(made, alone, made.ids)
    report = made.verify(comm)
    check(report and report.skipped == ("volumes", "euler"), f"{report}")
    check(made.volumes is None and np.array_equal(made.points, points[made.ids]), "points of made")
    check(np.array_equal(np.sort(np.concatenate(comm.allgather(made.ids))), np.arange(len(points))), "all are made")


def refused(comm, kind, text, *arguments, function=pyvotess.mpi.tessellate, **options):
    try:
        function(*arguments, **options)
    except kind as error:
        messages = comm.allgather(str(error))
        check(len(set(messages)) == 1 and text in messages[0], f"{messages}")
    else:
        check(False, f"not refused: {text}")


def wrong_on_one_rank(comm, points):
    """A wrong or another argument of one rank ends the call on all ranks, for each argument of each function."""
    last = comm.size - 1
    box = (0, 0, 0, 1, 1, 1)
    t = pyvotess.mpi.tessellate(points, comm, box=box)

    def on_last(function, name, value, *arguments, text=None, **options):
        if comm.rank == last:
            options[name] = value
        text = text or f"rank {last}: {name} "
        refused(comm, ValueError, text, *arguments, function=function, **options)

    same = "differs from that of rank 0"
    for name, value in (("sample", -1), ("sample", "x"), ("sample", 3), ("rng_seed", -1), ("rng_seed", None), ("rng_seed", 7)):
        on_last(t.verify, name, value, comm, points=points)
    on_last(t.verify, "points", points[:, :2], comm)
    on_last(t.verify, "points", None, comm, points=points, text=f"rank {last}: verify: points ")
    for name, value in (
        ("ids", np.zeros(2)), ("ids", np.ma.masked_array(np.arange(len(points)), np.arange(len(points)) == 1)),
        ("box", (0, 0, 0, 2, 2, 2)), ("periodic", "w"), ("periodic", "x"), ("weights", np.zeros(2)),
        ("want", "else"), ("want", "volumes,radii"), ("cell", 3), ("walls", 3), ("walls", ((1, 0, 0, 2),)),
        ("list_walls", True), ("threads", -1), ("duplicates", "x"), ("origin", (0, 0, 0)), ("outside", "keep"),
        ("cells", "made"), ("progress", 3),
    ):  # fmt: skip
        on_last(pyvotess.mpi.tessellate, name, value, points, comm, box=box)
    on_last(pyvotess.mpi.tessellate, "box", "hull", points, comm, box=box, text="the call of ")
    each = np.ones(len(points))
    on_last(pyvotess.mpi.tessellate, "radii", each, points, comm, box=box, text="it has 0 radii")
    by_rank = {"weights" if comm.rank == last else "radii": each}
    refused(comm, ValueError, "another rank has", points, comm, box=box, **by_rank)
    functions = (t.verify, lambda: pyvotess.mpi.tessellate(points, comm))
    arguments = ((), (comm, points))[comm.rank != last]
    refused(comm, ValueError, same, *arguments, function=functions[comm.rank == last])


def dropped_by_rank(comm):
    """Ranks whose seeds are all dropped get each array that one machine gives them."""
    points = np.random.default_rng(3).random((30, 3)) + (comm.rank > 0) * np.array((2.0, 0, 0))
    want = "volumes,centroids,areas,normals,counts,surfaces,radii"
    options = {"box": (0, 0, 0, 1, 1, 1), "outside": "drop", "want": want}
    t = pyvotess.mpi.tessellate(points, comm, **options)
    alone = pyvotess.tessellate(points, device="cpu", **options)
    if comm.rank:
        same_rows(t, alone, np.arange(30))
    for name in ("status", "volumes", "centroids", "surface_areas", "security_radii", "face_counts", "edge_counts",
                 "vertex_counts"):  # fmt: skip
        ours, theirs = getattr(t, name), getattr(alone, name)
        check(ours.shape == theirs.shape, f"{name} of rank {comm.rank} has shape {ours.shape}")
        check(comm.rank == 0 or np.array_equal(ours, theirs, equal_nan=True), f"{name} of dropped seeds")
    check(t.verify(comm, points), "dropped seeds")
    made = pyvotess.mpi.tessellate(points, comm, cells="made", **options)
    check(np.array_equal(np.sort(np.concatenate(comm.allgather(made.ids))), np.arange(30)), "dropped seeds are on no rank")
    check(made.verify(comm), "dropped seeds, made")


def stopped_by_one_rank(comm, points):
    """An error of one rank's callback leaves that rank; the others are cancelled, and all can go on."""
    last = comm.size - 1

    def progress(fraction):
        raise ZeroDivisionError

    try:
        pyvotess.mpi.tessellate(points, comm, progress=progress if comm.rank == last else None)
    except ZeroDivisionError:
        check(comm.rank == last, "an error of another rank")
    except pyvotess.VotessError as error:
        check(comm.rank != last and error.code == pyvotess.ErrorCode.CANCELLED, "which rank stopped")
        check(str(error).startswith(f"rank {last}:"), str(error))
    else:
        check(False, "not stopped")
    refused(comm, ValueError, "progress must be callable", points, comm, progress=3)
    fractions = []
    pyvotess.mpi.tessellate(points, comm, progress=fractions.append)
    check(fractions == sorted(fractions) and len(fractions) > 0, f"{fractions}")


def main():
    random = np.random.default_rng(1)
    points = random.random((3000, 3))
    with_one_machine(WORLD, points, box=(0, 0, 0, 1, 1, 1))
    with_one_machine(WORLD, points, box=(0, 0, 0, 1, 1, 1), periodic="xz", each={"radii": 0.02 * random.random(3000)})
    with_one_machine(WORLD, points[:3], cell=((1, 0, 0), (0.3, 1, 0), (0, 0.2, 1)))

    with_one_machine(WORLD, points[:300], box="hull", list_walls=True)
    with_one_machine(WORLD, points[:500, :2], box="hull")
    with_one_machine(WORLD, points[:500, :2], box=(0, 0, 1, 1), periodic="xy", each={"weights": 0.0001 * random.random(500)})

    part = WORLD.Split(WORLD.rank % 2)
    with_one_machine(part, points[:500] + WORLD.rank % 2, list_walls=True)
    part.Free()

    last = WORLD.size - 1
    own = points[WORLD.rank :: WORLD.size].copy()
    # Numbered rank after rank; float32 is read as it is.
    numbered = pyvotess.mpi.tessellate(own.astype(np.float32), WORLD, box=(0, 0, 0, 1, 1, 1))
    check(numbered.ids[0] == sum(WORLD.allgather(len(own))[: WORLD.rank]), "ids that were not given")
    bad = own.copy()
    if WORLD.rank == last:
        bad[5, 1] = np.nan
    sixth = WORLD.bcast(int(numbered.ids[5]), last)
    refused(WORLD, ValueError, f"rank {last}: point {sixth}: y = nan", bad, WORLD)
    refused(WORLD, ValueError, f"rank {last}: point 5: y = nan", bad, WORLD, ids=numbered.ids)
    shape = own if WORLD.rank != last else own[:, :2]
    refused(WORLD, ValueError, f"rank {last}: the number of dimensions differs", shape, WORLD)
    refused(WORLD, ValueError, "ids has shape", own, WORLD, ids=np.arange(2))
    refused(WORLD, ValueError, "id 4 is given twice", own, WORLD, ids=np.full(len(own), 4))
    refused(WORLD, ValueError, "cells is 'mine'", own, WORLD, cells="mine")
    wrong_on_one_rank(WORLD, own)
    dropped_by_rank(WORLD)
    refused(WORLD, pyvotess.VotessError, "vertices", own, WORLD, want="vertices")
    for _ in range(3):
        stopped_by_one_rank(WORLD, own)
    try:
        pyvotess.mpi.tessellate(own, "world")
    except TypeError as error:
        check("comm must be" in str(error), str(error))
    else:
        check(False, "a comm of another type")


try:
    main()
except BaseException:
    traceback.print_exc()
    sys.stderr.flush()
    WORLD.Abort(1)
if WORLD.rank == 0:
    print("pyvotess.mpi: the same as on one rank")
