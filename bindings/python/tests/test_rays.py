"""Rays through cells: arguments and results. The cells themselves are tested in C++ (tests/cases/query/trace.cpp)."""

import numpy as np
import pytest
import pyvotess as vt

BOX = (0, 0, 0, 1, 1, 1)


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(3).random((300, 3))


@pytest.mark.parametrize("periodic", [False, True])
def test_pieces_are_where_locate_finds_them(points, periodic):
    d = vt.Diagram(points, box=BOX, periodic=periodic)
    rng = np.random.default_rng(4)
    origins, ends = rng.random((2, 100, 3))
    cells = d.trace(origins, ends - origins)
    assert len(cells) == 100 and repr(cells) == f"<pyvotess.RayCells: 100 rays through {len(cells.seeds)} cells>"
    length = np.linalg.norm(ends - origins, axis=1)
    np.testing.assert_allclose(cells.integrate(np.ones(300)), length, rtol=1e-13)
    rays = np.repeat(np.arange(100), np.diff(cells.offsets))
    passed = np.cumsum(cells.lengths)
    passed -= np.concatenate([[0], passed])[cells.offsets[rays]]
    middle = (passed - 0.5 * cells.lengths) / length[rays]
    long = cells.lengths > 1e-9
    found = d.locate(origins[rays] + middle[:, None] * (ends - origins)[rays])
    np.testing.assert_array_equal(found[long], cells.seeds[long])


def test_integrals_of_columns(points):
    d = vt.Diagram(points, box=BOX)
    cells = d.trace([(0.5, 0.5, 0.5), (2, 2, 2), (0.1, 0.1, 0.1)], [(1, 0, 0)] * 3, np.inf)
    assert cells.offsets[1] == cells.offsets[2] and cells.seeds.dtype == np.int32
    values = np.random.default_rng(5).random((300, 2))
    both = cells.integrate(values)
    assert both.shape == (3, 2) and (both[1] == 0).all()
    np.testing.assert_array_equal(both[:, 1], cells.integrate(values[:, 1]))
    first = slice(0, cells.offsets[1])
    assert both[0, 0] == pytest.approx(values[cells.seeds[first], 0] @ cells.lengths[first], rel=1e-13)


def test_refusals(points):
    d = vt.Diagram(points, box=BOX, periodic=True)
    at = [(0.5, 0.5, 0.5)]
    with pytest.raises(ValueError, match="ray 0: its direction is 0"):
        d.trace(at, [(0, 0, 0)])
    with pytest.raises(ValueError, match="not finite"):
        d.trace(at, [(np.nan, 0, 0)])
    with pytest.raises(ValueError, match="its length -1 is not 0 or more"):
        d.trace(at, [(1, 0, 0)], -1)
    with pytest.raises(ValueError, match="no wall ends it"):
        d.trace(at, [(1, 0, 0)], np.inf)
    with pytest.raises(ValueError, match="1 origins, but 2 directions"):
        d.trace(at, [(1, 0, 0)] * 2)
    with pytest.raises(ValueError, match="lengths has shape"):
        d.trace(at, [(1, 0, 0)], [1, 2])
