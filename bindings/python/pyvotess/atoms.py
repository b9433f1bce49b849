"""Atoms of other packages, recognized by their attributes. None of these packages is imported."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Tuple, Union, overload

import numpy as np

from ._domain import DomainLike, take_domain
from .tessellator import Tessellator, tessellate

if TYPE_CHECKING:
    from ._types import Float64Array
    from .tessellation import Tessellation

#: positions (N, 3), edges of the cell (3, 3), its corner (3,), and periodic flags
_Parts = Tuple[Any, Any, Any, Any]

_KEPT = ("device", "threads", "precision", "grid_resolution", "k_init", "chunk_size", "instructions")


def _edges_of_lengths_and_angles(dimensions: Any) -> Float64Array:
    """Returns edges (3, 3) for lengths a, b, c and angles bc, ac, ab in degrees: a along x, b in the plane of x and y."""
    a, b, c, bc, ac, ab = (float(x) for x in dimensions)
    # Right angles have a cosine of 0, which radians would miss.
    cos_bc, cos_ac, cos_ab = (0.0 if angle == 90 else float(np.cos(np.deg2rad(angle))) for angle in (bc, ac, ab))
    sin_ab = 1.0 if ab == 90 else float(np.sin(np.deg2rad(ab)))
    y = (cos_bc - cos_ac * cos_ab) / sin_ab
    return np.array([[a, 0, 0], [b * cos_ab, b * sin_ab, 0], [c * cos_ac, c * y, c * np.sqrt(1 - cos_ac**2 - y**2)]])


def _corner_of_ase(atoms: Any) -> Float64Array:
    """Returns the corner of the cell. ASE's reader of extended XYZ and OVITO's converter keep it in ``info`` alone."""
    corner = np.ravel(atoms.get_celldisp()) if hasattr(atoms, "get_celldisp") else np.zeros(3)  # (3, 1) there
    for key, value in {} if np.any(corner) else getattr(atoms, "info", {}).items():
        if str(key).lower() in ("origin", "cell_origin") and np.shape(value) == (3,) and np.asarray(value).dtype.kind in "fiu":
            return np.asarray(value, dtype=np.float64)
    return corner


def _parts_of(atoms: Any) -> _Parts:
    zero = np.zeros(3)
    if hasattr(atoms, "get_positions") and hasattr(atoms, "pbc"):  # ASE
        corner = _corner_of_ase(atoms)
        return atoms.get_positions(), np.asarray(atoms.cell, dtype=np.float64), corner, atoms.pbc
    if hasattr(atoms, "cart_coords") and hasattr(atoms, "lattice"):  # pymatgen's Structure
        return atoms.cart_coords, atoms.lattice.matrix, zero, getattr(atoms.lattice, "pbc", (True, True, True))
    if hasattr(atoms, "particles") and hasattr(atoms, "cell"):  # OVITO's DataCollection
        if atoms.cell is None:
            return np.asarray(atoms.particles.positions), np.zeros((3, 3)), zero, (False, False, False)
        columns = np.asarray(atoms.cell)  # a, b, c and the corner
        return np.asarray(atoms.particles.positions), columns[:, :3].T, columns[:, 3], atoms.cell.pbc
    if hasattr(atoms, "atoms") and hasattr(atoms.atoms, "positions"):  # MDAnalysis: a Universe or a group of atoms
        atoms = atoms.atoms
        if atoms.dimensions is None:
            return atoms.positions, np.zeros((3, 3)), zero, (False, False, False)
        return atoms.positions, _edges_of_lengths_and_angles(atoms.dimensions), zero, (True, True, True)
    raise TypeError(
        f"atoms are a {type(atoms).__name__}: known are objects of ASE, pymatgen, MDAnalysis and OVITO; give positions "
        "and cell to tessellate()"
    )


def _cells_of(atoms: Any, options: Dict[str, Any], tessellator: Optional[Tessellator]) -> Tessellation:
    positions, edges, origin, periodic = _parts_of(atoms)
    given = dict(options)
    if given.get("domain") is None:
        if given.get("box") is None and np.any(edges):
            given.update(cell=edges, origin=origin)
        given.setdefault("periodic", tuple(bool(axis) for axis in np.broadcast_to(periodic, 3)))
    return (tessellator.tessellate if tessellator else tessellate)(positions, **given)


def _cells_of_each(frames: Any, options: Dict[str, Any]) -> Iterator[Tessellation]:
    kept = {name: options.pop(name) for name in _KEPT if name in options}
    with Tessellator(**kept) as tessellator:
        for number, atoms in enumerate(frames):
            try:
                yield _cells_of(atoms, options, tessellator)
            except (TypeError, ValueError) as error:
                raise type(error)(f"frame {number}: {error}") from error


@overload
def from_ase(atoms: List[Any], domain: Optional[DomainLike] = ..., **options: Any) -> List[Tessellation]: ...
@overload
def from_ase(atoms: Iterator[Any], domain: Optional[DomainLike] = ..., **options: Any) -> Iterator[Tessellation]: ...
@overload
def from_ase(atoms: Any, domain: Optional[DomainLike] = ..., **options: Any) -> Tessellation: ...
def from_ase(
    atoms: Any, domain: Optional[DomainLike] = None, **options: Any
) -> Union[Tessellation, List[Tessellation], Iterator[Tessellation]]:
    """Returns the cells of atoms, in the unit cell of the atoms and periodic along its periodic edges.

    Parameters
    ----------
    atoms : ``ase.Atoms``, a pymatgen Structure, an MDAnalysis Universe or AtomGroup (periodic along all edges if it has
        dimensions), or an OVITO DataCollection. The result has their unit of length. A list or tuple of them gives a
        list of results, and an iterator such as ``ase.io.iread(file)`` an iterator: one :class:`Tessellator` makes all.
    domain : replaces the cell of the atoms and their periodic flags.
    options : of :func:`tessellate`, except points, cell and origin. ``periodic`` overrides that of the atoms;
        ``box`` replaces their cell.

    The corner of ASE's cell is ``celldisp``, or ``info["Origin"]`` where that is 0: its reader of extended XYZ puts the
    corner there, and OVITO's converter into ``info["cell_origin"]``. Remove it from ``info`` if you move the atoms.

    Atoms without a cell get the default box of :func:`tessellate`. An atom outside of the cell along an edge without
    period is an error, or dropped with ``outside="drop"``.

    Raises TypeError for objects of an unknown type, and ValueError for a cell that repeats along an edge of length 0.
    Along other edges of length 0, as those of ASE's surfaces, the domain has no end.

    >>> from ase.build import bulk
    >>> vt.from_ase(bulk("Al", cubic=True), want="volumes").volumes.round(3)
    array([16.608, 16.608, 16.608, 16.608])
    """
    for name in ("cell", "origin"):
        if name in options:
            raise TypeError(f"from_ase() takes {name} from the atoms: give positions and {name} to tessellate()")
    if domain is not None:
        options["domain"] = domain
        options["domain"] = take_domain(options)
    if isinstance(atoms, (list, tuple)):
        return list(_cells_of_each(atoms, options))
    if isinstance(atoms, Iterator):
        return _cells_of_each(atoms, options)
    return _cells_of(atoms, options, None)
