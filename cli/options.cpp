#include "options.hpp"

#include <algorithm>
#include <votess/row_arrays.hpp>

namespace clvotess {

using votess::Options;

namespace {

// The groups of arrays, a line each.
const std::string& text_of_want() {
    static const std::string text = [] {
        std::string lines = "arrays to write, such as face_areas,security_radii, or groups of them:";
        for (const votess::GroupInfo& group : votess::array_groups) {
            std::string arrays;
            votess::for_all_arrays([&](const auto& array) {
                if (array.word == group.word) arrays.append(arrays.empty() ? "" : ", ").append(array.name);
            });
            lines.append("\n").append(group.name).append(": ").append(arrays);
        }
        return lines + R"(
An array brings its group. Default neighbors,volumes; an output that needs
more adds it. Polygons (faces, %a %A %e %E %o %t, .vtu, .ply, .obj) add
--list-walls)";
    }();
    return text;
}

}  // namespace

const std::vector<Option>& option_table() {
    static const std::vector<Option> table{
        {"", "input"},
        {"INPUT",
         R"(.xyz .txt .dat .csv  rows of text `x y z` or `id x y z`, separated by
                blanks, tabs, commas or semicolons; # begins a comment; ids
                are whole numbers. A .csv may begin with a line of names,
                which finds x, y, z and id. An .xyz may hold frames: a
                count, a comment and rows `Element x y z`. In extended XYZ
                the comment has Properties=, Lattice=, Origin= and pbc=
.extxyz         the same as .xyz
.npy .npz       NumPy arrays (N, 3), float64 or float32; in .npz the array
                `points`, the only one that fits, or x, y and z; ids
.h5 .hdf5       a dataset (N, 3) of floats, or frames (T, N, 3) of H5MD and
                MDTraj. Snapshots of Gadget, AREPO and SWIFT, in several
                files by NAME.0.hdf5 or NAME; ParticleIDs, ids
.dump .lammpstrj  LAMMPS dump in text, also called dump.NAME
.data .lmp      LAMMPS data file, its section Atoms; also data.NAME. The
                atom style (`Atoms # full`) or a line of names finds the
                columns; without one their number does, in common styles.
                Other words after # are a comment
POSCAR CONTCAR .vasp  of VASP
.tess           of Neper: seeds, domain, ids; weights: --radii radius
.ply            element vertex: x y z, id
NAME, -         text without an extension; on stdin
Any text may be packed: .xyz.gz, .dump.gz, ...)",
         {.brief = "points: text, .xyz, .npy, .npz, .h5, .ply, LAMMPS, POSCAR, .tess; - stdin", .on_surface = true}},
        {"--dataset NAME",
         R"(dataset of .h5, or its group such as PartType1, or array of .npz; default:
the only one that fits. Velocities and forces do not)",
         {.on_surface = true}},
        {"--frame N", R"(frame of a LAMMPS dump, .xyz or .h5, from 0; default: the first)", {.on_surface = true}},
        {"--frames all|last|a:b:c",
         R"(all frames, the last, or frames a to b - 1 in steps of c, in one pass. The
output holds one after the other: .h5 has a group frame_NUMBER for each,
text a header line, .csv a column `frame`.
A file that holds one frame needs {frame} in its name for the number, as in
cells-{frame}.vtu; it is complete when the frame is. Summary and --json
have sums)",
         {.needs = Needs::all_points}},
        {"--points",
         R"(compute no cells; write the points, ids, species, columns of --copy and
domain of each frame to stdout, in the form that vt.read_frames reads)",
         {.needs = Needs::all_cells, .with = "--frames"}},
        {"--columns X,Y[,Z]",
         R"(the columns of the coordinates, by names of a header line such as
"Points:0,Points:1,Points:2" or "x [Mpc],y [Mpc],z [Mpc]", or by numbers
from 1. Of rows of text, .npz (arrays), .ply and LAMMPS dumps. Two names
mean --2d)",
         {.on_surface = true}},
        {"--random N",
         R"(N uniform points in the unit box, such as 100000 or 1e6, instead of INPUT;
with --2d in the unit square, with --mesh inside of the mesh, with
--surface on it. The domain is that box unless --box is given)",
         {.brief = "N uniform points in the unit box instead of INPUT", .on_surface = true}},
        {"--rng-seed S",
         R"(start of the random numbers; default 1. The same on every machine)",
         {.with = "--random|--remesh", .on_surface = true}},
        {"", "domain"},
        {"--2d",
         R"(two dimensions: the cells are polygons. Input are rows `x y` or `id x y`,
arrays (N, 2), or files with z whose points have one z. Give two numbers
for each vector: --box x0,y0,x1,y1, --cell ax,ay,bx,by, --origin x,y and
--wall nx,ny,d. volumes are areas, surface_areas perimeters, face_areas and
--min-area lengths of edges; vectors have two components. Points of two
coordinates, as in rows of two columns, imply it, and the summary says so)"},
        {"--box x0,y0,z0,x1,y1,z1|none|hull",
         R"(the domain. Default: the bounds of the points, each side moved out by half
of (longest side / cbrt(N)). A point outside a given box is an error. none:
all of space; cells that reach infinity have the volume inf and wall -1. A
bound may be inf or -inf alone, other axes periodic: a slab without end.
hull: the convex hull of the points, whose facets become walls)",
         {.brief = "the domain; default: around the points, or as the file states"}},
        {"--periodic [xyz|none]",
         R"(axes along which the box repeats; without a value: all three. Points beyond
it are wrapped into it. Needs a box, from --box, --cell or the file)",
         {.brief = "axes along which the domain repeats; without a value: all three"}},
        {"--cell ax,ay,az,bx,by,bz,cx,cy,cz",
         R"(a triclinic box instead of --box, periodic along its edges a, b and c, or
along those that --periodic names as x, y and z. Across the others it ends
at the planes of its faces, walls -1 to -6, or nowhere if the edge is 0)",
         {.brief = "a triclinic box, periodic along its edges"}},
        {"--origin x,y,z",
         R"(corner of --cell; default 0,0,0
Without --box and --cell, a file that states its domain gives it: LAMMPS,
extended XYZ, POSCAR, BoxSize of a snapshot, .npz and .h5 of clvotess. Axes
that the file does not mention are periodic for LAMMPS without boundary
flags, POSCAR, and XYZ without pbc, but not for snapshots. --periodic then
chooses which axes of that box repeat)",
         {.with = "--cell"}},
        {"--wall nx,ny,nz,d",
         R"(keep the side where nx x + ny y + nz z <= d. Repeatable: walls bound a
convex polyhedron and have the ids -7, -8, ...)",
         {.repeats = true}},
        {"--wall-sphere x,y,z,r,FACES", "", {.repeats = true, .solid = true}},
        {"--wall-cylinder x,y,z,ax,ay,az,r,FACES", "", {.repeats = true, .solid = true}},
        {"--wall-cone x,y,z,ax,ay,az,ANGLE,FACES",
         R"(FACES walls that touch a sphere, a cylinder without ends or a cone from
outside. The axis of a cone points from its apex inwards; ANGLE is that
between axis and surface, in radians. The volume grows by about 3 / FACES
for a sphere, 3 / FACES^2 otherwise. The ids follow those of --wall)",
         {.repeats = true, .solid = true}},
        {"--mesh FILE",
         R"(a closed mesh as the domain: each cell is its part inside. .off, .obj,
.ply, .stl (text and binary) or .glb (y is up there, and becomes z);
vertices of .stl and .glb at equal places become one. Polygons must be flat
and simple. Seen from outside, corners are counterclockwise. Seeds may lie
outside of the mesh. It replaces the domain that INPUT states; --box must
hold it. Into text without polygons, .csv, .xyz, .dump, .npz and .h5;
surface_areas brings mesh_areas. Into
.vtu, .glb, .obj, .stl and .3mf the connected pieces of cells: closed
objects, in .vtu with the id of their cell, in others named by it, as "17",
or "17.0", "17.1" if a cell has several; materials are inside and surface.
Into .foam, .msh and .cgns the pieces with shared faces; the surface is a
patch, or surface1 and on where it is in several parts.
--image draws pieces. Queries have answers inside: --to-grid is 0 outside,
and rays have their parts inside.
.geojson, and .geojsonl with one GeoJSON text a line: polygons with holes,
in two dimensions, which they imply. Where polygons overlap, places count
as often as they lie in one. Into .geojson the pieces of cells as polygons)",
         {.needs = Needs::all_points}},
        {"--min-edge LENGTH",
         R"(in .foam, .tess, .msh, .cgns and .stl: make one vertex of the ends of
shorter edges. Faces with two corners vanish, cells stay closed, and
vertices on their walls. Reports edges that stay: a cell would be none)",
         {.needs = Needs::cells}},
        {"--gap WIDTH",
         R"(in .glb, .obj, .stl, .3mf, .geojson and --image: leave this distance
between pieces. The planes of each cell move inward by half of it; the
surface of the mesh stays)",
         {.with = "--mesh"}},
        {"--mesh-repair merge",
         R"(make vertices of the mesh at equal places one, as for .stl and .glb)",
         {.with = "--mesh|--surface", .on_surface = true}},
        {"--mesh-tolerance SHARE",
         R"(with --mesh-repair merge, .stl or .glb: make vertices one that are at most
this far apart, as a share of the longest side of the mesh's bounds; 1e-9
closes meshes whose corners differ by rounding. At most 0.01. The summary
says how many vertices moved, and how far)",
         {.with = "--mesh|--surface", .on_surface = true}},
        {"--surface FILE",
         R"(cells on a surface instead: the part of each cell on the triangles of FILE,
a mesh as for --mesh that need be neither closed nor oriented alike. Cells
are those of all space; INPUT may be --random N, N places on the surface.
Into .csv (area, perimeter, border, neighbors, pieces, Euler's
characteristic and centroid of each part), .npz and .h5 (every array of
SurfaceCells in Python), and the dual into .obj, .ply, .off and .stl: a
triangle where three cells meet. --json counts faults: cells at which the
dual may differ from the surface. Goes with --weights, --radii,
--mesh-repair, --mesh-tolerance and --threads)",
         {.needs = Needs::all_cells, .solid = true, .on_surface = true}},
        {"--remesh N",
         R"(a mesh of even triangles with N vertices for the surface, about 2 N
triangles, without INPUT. About N where parts of the surface are thinner
than its triangles. Borders and sharp edges are kept. Into .obj, .ply,
.off, .stl, .npz and .h5. The summary has the smallest angle and the
distance between the meshes)",
         {.needs = Needs::all_cells, .with = "--surface", .on_surface = true}},
        {"--sharp DEGREES",
         R"(an edge is sharp if the surface turns there by more; default 40. 180: keep
borders alone)",
         {.needs = Needs::all_cells, .with = "--remesh", .on_surface = true}},
        {"--outside error|drop|keep",
         R"(points outside the domain: an error; or dropped, which leaves an empty cell
with the status `outside`; or kept, which gives each the part of its cell
inside the domain, or the status `empty`)",
         {.member = Word<votess::Outside>(&Options::outside), .start = "error"}},
        {"--only FILE|RANGE",
         R"(cells of some points among all: a range of indices from 0, as 5, 0:100 or
::10, or a file of indices: text, or .npy, also of a flag for each point.
Rows come in this order, and `ids` names their points. Into text, .csv,
.xyz, .dump, .npz or .h5)",
         {.needs = Needs::all_cells}},
        {"--min-face SHARE",
         R"(drop faces between two cells with an area below this share of the mean of
all such faces. They leave lists, areas, normals, polygons and face counts;
walls and vertices stay. The cell of lower index decides for both, so lists
stay symmetric. 0 drops none)",
         {.member = Number(&Options::min_face), .needs = Needs::all_cells}},
        {"--min-area AREA",
         R"(drop faces below this area, as --min-face does; the larger limit counts)",
         {.member = Number(&Options::min_area), .unit = "length unit squared", .needs = Needs::all_cells}},
        {"--weights COL", R"(power diagram: COL holds the weights)", {.on_surface = true}},
        {"--radii COL",
         R"(power diagram: COL holds radii, whose squares are the weights. COL is the
number of a column from 1, or a name: of .csv with a line of names, LAMMPS,
.ply, an array or dataset of N numbers; for atom style sphere
also `radius`. covalent: radii in angstrom of the elements that the file
names (Cordero and others 2008, doi:10.1039/b801115j))",
         {.brief = "power diagram: a column of the input holds radii (--weights: their squares)", .on_surface = true}},
        {"--volumes COL",
         R"(power diagram in which each cell has the volume that COL holds, in two
dimensions the area. The weights are found by damped Newton steps and
written as the array `weights`. --weights or --radii are the start)",
         {.needs = Needs::all_cells}},
        {"--tolerance T",
         R"(largest relative error of a volume; default 1e-9)",
         {.needs = Needs::all_cells, .with = "--volumes"}},
        {"--max-steps N",
         R"(Newton steps at most; default 200. If they do not reach the tolerance, no
file is written and the exit code is 1)",
         {.needs = Needs::all_cells, .with = "--volumes"}},
        {"--normalize",
         R"(scale the volumes to that of the domain: they are shares of it)",
         {.needs = Needs::all_cells, .with = "--volumes"}},
        {"--copy COLS",
         R"(columns of the input to copy into the output, with commas between them, or
`all` that hold numbers; "a, b" in quotes is one name. Text gets them at
the end of the row, other files as arrays. Names and `all` need a header
line, as in .csv. A named column may hold words; `species` is that of
elements or types, whatever its name)",
         {.needs = Needs::cells}},
        {"--density COL",
         R"(write the array `density`: COL divided by the volume. A duplicate adds its
number to the point that keeps the cell; without a cell density is nan)",
         {.needs = Needs::cells}},
        {"--watershed COL",
         R"(write the array `zone`: the number of the minimum of COL that steps to the
lowest neighbor reach from each cell; -1 without a cell. Minima are in the
order of the points. COL may be `density`, if --density is given)",
         {.needs = Needs::all_cells}},
        {"--merge LEVEL",
         R"(join zones that end at most LEVEL above their minimum with the zone across
that saddle; `zone` numbers the rest. 0 joins zones that only ties divide)",
         {.needs = Needs::all_cells, .with = "--watershed"}},
        {"--alpha N",
         R"(write the alpha complex of N copies of a box along each periodic vector; N
is 1 for other domains, which count as all of space. For each dimension K
from 0 to 3, or to 2: alpha_seeds_K, K + 1 seeds of each simplex;
alpha_values_K, its squared radius; alpha_gabriel_K, 1 if its smallest
sphere is empty; in periodic domains alpha_shifts_K, a number for each axis
of each seed. Into .npz or .h5)",
         {.needs = Needs::all_cells}},
        {"--duplicates merge|error",
         R"(points of equal coordinates: the lowest index keeps the cell and the others
get an empty one, or the input is refused)",
         {.member = Word<votess::Duplicates>(&Options::duplicates), .start = "merge"}},
        {"", "output"},
        {"-o, --output FILE",
         R"(.txt   one row per point, in the order of the input, see --format
.csv .xyz .dump  tables with volume, neighbors (their number) and n3 to n7,
       the Voronoi index (faces of 3 to 6 and of 7 or more edges), or with
       the columns of --want; .xyz is extended, .dump that of LAMMPS.
       In two dimensions area and perimeter, and no index
.npz   NumPy arrays: indptr, indices (row i of the neighbor lists is
       indices[indptr[i]:indptr[i+1]]), shifts in periodic domains, the
       arrays of --want, status, duplicate_of if there are duplicates, ids,
       the domain (box, periodic, cell, origin, walls) and its source
       (domain_from, periodic_from: option, stated, assumed, default),
       units that the file states, version
.h5    HDF5: the same (also .hdf5), the domain and units as attributes
.vtu   the cells as polyhedra for ParaView, PyVista and meshio, in two
       dimensions as polygons, with id, volume, neighbors, centroid and
       status; without empty cells, ascending by their number of vertices:
       id names the point
.ply   the faces, each once, with its two cells (rows from 0, walls < 0)
.obj   a group for each cell, named by its row (from 0), with its faces
.glb   glTF: the cells as solids in flat colors by --color, for Blender
       and browsers, about 830 bytes a cell, 4 GiB at most; the
       attribute _CELL is the row of the input
.foam  a mesh of OpenFOAM: folder constant/polyMesh beside the file, which
       is empty, for ParaView. Walls are patches, periodic boundaries pairs
       of cyclic patches. Reports non-orthogonality and skewness on stderr
.tess  Neper: polyhedra with shared faces, seeds and weights, not periodic
.msh   Gmsh: surfaces in triangles, each once, with a physical volume for
       each cell and a physical surface for each pair and each wall
.cgns  CGNS 3.4: a zone of NGON_n and NFACE_n, with the row of each cell.
       Walls are boundary conditions, periodic boundaries connections
.stl   text: a solid for each cell, named by its row (from 0)
.stl .3mf  pieces of cells in a mesh, as .obj and .glb hold: see --mesh
.geojson   pieces of cells in polygons: see --mesh
-      text on stdout
Repeatable. A file is written whole or not at all. A device or a pipe
without an extension, such as /dev/null, gets text)",
         {.brief = ".txt .csv .xyz .dump .npz .h5 .vtu .ply .obj .glb .foam .msh, -",
          .repeats = true,
          .on_surface = true}},
        {"--format FMT",
         R"(a row of text, with the codes of Voro++; default "%i %n"
  %i  id: that of the input, else the index from 0
  %x %y %z  coordinates of the input  %q  the three: "x y z"
  %r  radius, from --radii; without it 0.5, as Voro++ prints
  %w  number of vertices        %o  number of edges at each vertex
  %p  vertices relative to the point "(x,y,z) ..."    %P  absolute
  %m  largest squared distance of a vertex from the point
  %g  number of edges           %E  sum of their lengths
  %s  number of faces, walls included
  %n  neighbors of the faces, ids ascending, walls first; in this order:
  %f  areas     %e  perimeters  %a  numbers of edges  %l  outward normals
  %t  vertices of each face "(0,3,1) ...", numbers into %p, clockwise
      seen from outside; -1 at infinity
  %A  how many faces have 0, 1, 2, ... edges
  %F  area of the surface       %v  volume
  %c  centroid relative to the point "x y z"          %C  absolute
  (a point beyond a periodic box counts where it lies inside)
  %%  a percent sign
In two dimensions faces are edges: %f lengths, %F perimeter, %v area, %p
corners counterclockwise; %z %a %A %e %E %o and %t are refused.
Numbers have the fewest digits that read back as the same float64)",
         {.brief = "rows of text with the codes of Voro++, such as \"%i %q %v %n\"", .needs = Needs::cells}},
        {"--want LIST",
         text_of_want(),
         {.brief = "arrays to write: neighbors,volumes (default), face_areas, faces, ...", .needs = Needs::cells}},
        {"--list-walls",
         R"(list walls as neighbors too: -1 to -6 = xmin, xmax, ymin, ymax, zmin, zmax
of the box, or the faces of a cell across a, b and c; -7, -8, ... = walls)",
         {.member = Flag(&Options::list_walls), .needs = Needs::cells}},
        {"--json", R"(print the summary as one JSON object)", {.on_surface = true}},
        {"-q, --quiet", R"(print neither summary nor progress)", {.on_surface = true}},
        {"", "picture"},
        {"--image FILE.png",
         R"(a picture of the cells, cut open, drawn on the CPU. Cells at the walls that
dwarf the others are omitted, with their neighbors. In two dimensions all
cells, with axes)",
         {.brief = "a picture of the cells, cut open; --slice z=0.5 for a section", .needs = Needs::all_cells}},
        {"--slice x=VALUE",
         R"(draw a plane section instead, with axes; also y=VALUE, z=VALUE)",
         {.needs = Needs::all_cells, .with = "--image", .solid = true}},
        {"--color COLUMN",
         R"(volume (default), neighbors, area, x, y, z, index, the array volumes or
surface_areas, or a column of --copy or --density; on a logarithmic scale
where values differ widely)",
         {.needs = Needs::cells}},
        {"--colormap tide|ember|gray", R"(colors of the picture and of .glb; default tide)", {.needs = Needs::cells}},
        {"--cut corner|half|cells|none",
         R"(part to cut away: the octant in front (default), the half in front, the
whole cells whose points lie in that octant, or nothing)",
         {.needs = Needs::all_cells, .with = "--image", .solid = true}},
        {"--view AZIMUTH,ELEVATION",
         R"(direction of the camera in degrees; default 36,27)",
         {.needs = Needs::all_cells, .with = "--image", .solid = true}},
        {"--seeds",
         R"(with --slice or in two dimensions: draw the points near the plane as dots)",
         {.needs = Needs::all_cells, .with = "--image"}},
        {"--image-size WxH", R"(pixels; default 1600x1200)", {.needs = Needs::all_cells, .with = "--image"}},
        {"--open skip",
         R"(leave cells that reach infinity out of pictures and of .vtu, .ply, .obj and
.glb, and say how many; else they are refused)",
         {.needs = Needs::all_cells}},
        {"", "queries"},
        {"--locate QUERIES",
         R"(the cell that holds each point of the file QUERIES, as the index of its
point in the input from 0. Exact; the lowest index where cells meet, -1
outside the domain. Into -o FILE.npy (int32), FILE.txt or - (a line each).
In a periodic domain queries are wrapped)",
         {.needs = Needs::all_points}},
        {"--probe QUERIES",
         R"(the cell that each point of the file QUERIES would have if it alone were
added to the points: a row or polyhedron each, by --want, --list-walls and
--format, into text, .npz, .h5 or .vtu. Neighbors are indices of points in
the input from 0; the number of points is the query itself. Status 7:
outside the domain; 5: at the place of a point, whose cell this is and
which duplicate_of names; 6: heavier points leave no cell. With --weights
or --radii the column of that name or number is read from QUERIES too; 0 if
it has none)",
         {.needs = Needs::all_points}},
        {"--interpolate QUERIES",
         R"(the field of --values at each point of the file QUERIES, from its natural
neighbors among the points, into -o FILE.npy (float64), FILE.txt or - (a
line each); nan without neighbors, as outside the domain. Linear fields are
reproduced where the cell of a query has no wall; at walls cells end as if
the points had mirror images behind. Weights and radii as for --probe)",
         {.needs = Needs::all_points}},
        {"--trace RAYS",
         R"(the cells that each ray of the file RAYS passes, in order, and its length
in each. A row of its text or .npy holds the origin, the direction and the
length: seven numbers, in two dimensions five. Rays end at walls, and go
round where the domain repeats. Into -o FILE.txt or - (a line for each ray:
a seed, its length, the next seed), or into FILE.npz: row r of `seeds` and
`lengths` is seeds[offsets[r]:offsets[r+1]])",
         {.needs = Needs::all_points}},
        {"--values COLUMN[,COLUMN]",
         R"(columns of INPUT for --interpolate and --to-grid, by name or number as for
--weights)",
         {.with = "--interpolate|--to-grid"}},
        {"--natural sibson|laplace",
         R"(weights of --interpolate: the volumes that the cell of a query takes from
its neighbors (Sibson 1980, the default), or areas over distances)",
         {.with = "--interpolate"}},
        {"--to-grid mean|dtfe|nearest|sibson",
         R"(the field of --values on a regular grid over the domain, into -o FILE.npy,
FILE.h5 or FILE.vti (not for a triclinic box). A grid cell holds
mean      the exact average of the field that is constant in each cell
dtfe      the average density, linear in Delaunay tetrahedra or triangles;
          values are masses (Schaap and van de Weygaert 2000), without
          --values 1 each; the mass of points in no tetrahedron is omitted
nearest   the value of the cell that holds its center
sibson    the value of --interpolate at its center
The field is 0 beyond walls)",
         {.needs = Needs::all_points}},
        {"--shape NX,NY,NZ",
         R"(number of grid cells along x, y and z, or a, b and c of a triclinic box; N
means N,N,N. NX,NY in two dimensions)",
         {.with = "--to-grid"}},
        {"--project x|y|z",
         R"(sum the grid along that axis, or edge a, b or c, times the length of a grid
cell: a column density. --image FILE.png draws it, one pixel for each
number, the first axis to the right, in the colors of --colormap. In two
dimensions --image draws the whole grid)",
         {.with = "--to-grid"}},
        {"", "run"},
        {"-x, --device auto|cpu|gpu|lavapipe|INDEX",
         R"(where to run: auto = the first GPU, else the CPU; cpu; gpu = the first GPU;
lavapipe = the first Vulkan device that is software; or an index of
--list-devices. auto is the CPU for fewer than 10,000 points, which takes
less time than to open a GPU, and if the GPU fails or cannot serve the
request. Otherwise a missing device is an error)",
         {.brief = "where to run; default the first GPU, else the CPU",
          .member = Text(&Options::device),
          .start = "auto"}},
        {"--precision single|double",
         R"(relative error of volumes, centroids and areas from a GPU: 1e-5 or 1e-10.
The CPU always reaches 1e-10; the neighbors are exact either way)",
         {.member = Word<votess::Precision>(&Options::precision), .start = "single", .needs = Needs::cells}},
        {"--memory SIZE",
         R"(limit memory to SIZE bytes, such as 500M, 4G or (powers of 1024) 4Gi, for
points larger than memory. The CPU clips one block after the other; the
rest waits in temporary files. From .npy, .h5 (snapshots too) and rows of
text into .h5, the same file as without --memory; frames of .h5 into a file
each, as out-{frame}.h5. Not with vertices and faces, --min-face,
--min-area, --duplicates error, pictures and queries)",
         {.needs = Needs::one_machine}},
        {"--temporary DIR",
         R"(folder for the files of --memory; default: that of the first output. The
run first reports how much room they need. They have no names and vanish
when the run ends)",
         {.needs = Needs::one_machine, .with = "--memory"}},
        {"--verify",
         R"(check the result: volume sum, symmetry of the neighbors, Euler's formula,
and each cell by exact signs around it, which proves all neighbors. Few
cells of --only are compared with every point, and with --memory or ranks
in a domain without end a sample of at least 64. In --mesh the whole cells
are proven. The summary tells which it was. If a check fails, no file is
written and the exit code is 3)",
         {.brief = "check the result; exit code 3 if that fails", .needs = Needs::cells}},
        {"", "tuning: changes speed and memory, never the answer"},
        {"-t, --threads N",
         R"(CPU threads, an error if the system gives fewer; 0 = all that it gives)",
         {.member = Count(&Options::threads), .max = 1024, .on_surface = true}},
        {"-g, --grid-resolution N",
         R"(blocks along an axis of the sorting grid; 0 = automatic)",
         {.member = Count(&Options::grid_resolution), .max = 1048576}},
        {"-k, --k-init N",
         R"(GPU: nearest neighbors tried first for each cell; 0 = automatic)",
         {.member = Count(&Options::k_init), .max = 1024, .needs = Needs::cells}},
        {"--chunk-size N",
         R"(GPU: cells in flight at once; 0 = automatic)",
         {.member = Count(&Options::chunk_size), .needs = Needs::cells}},
        {"--follow",
         R"(keep the cells for the next frame, or call of a Tessellator: cells that
still hold there are not made again. Pays on the CPU, where seeds move by
at most a hundredth of their distance. Takes some 300 bytes a seed)",
         {.member = Flag(&Options::follow), .needs = Needs::all_cells, .with = "--frames"}},
        {"--instructions NAME",
         R"(CPU: baseline, avx2 or avx512; default: the best that the processor has.
One that it lacks is an error)",
         {.member = Text(&Options::instructions)}},
        {"", "else"},
        {"--list-devices",
         R"(list the devices of this machine: value for -x, name,
description; with --json as a JSON array)"},
        {"--version", R"(print the version)"},
        {"-h, --help", R"(list the usual options)"},
        {"--help-all", R"(list every option in detail: this text)"},
        {"--man", R"(print this text as a manual page, for man -l)"},
        {"--completion bash|zsh|fish", R"(print the completions of these options for that shell:
source <(clvotess --completion bash))"},
        {"--voro++ ARGUMENTS", R"(as first argument: read the rest as the command line of voro++, and write
FILE.vol as it does. Accepts -c -l -m -n -o -p -px -py -pz -r -v, the box
and FILE)"},
    };
    return table;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (;;) {
        const auto end = text.find(separator);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

std::vector<std::string_view> names_of(const Option& option) {
    std::vector<std::string_view> names;
    std::string_view rest = option.names;
    while (rest.starts_with('-')) {
        const auto end = rest.find_first_of(", ");
        names.push_back(rest.substr(0, end));
        rest.remove_prefix(std::min(rest.find_first_not_of(", ", end), rest.size()));
    }
    return names;
}

std::string long_name(const Option& option) {
    const auto names = names_of(option);
    return std::string(names.empty() ? option.names : names.back());
}

std::string_view value_of(const Option& option) {
    const auto blank = option.names.rfind(' ');
    const std::string_view last = option.names.substr(blank + 1);
    return blank == std::string_view::npos || last.starts_with("-") ? std::string_view() : last;
}

std::vector<std::string_view> words_of(const Option& option) {
    std::string_view value = value_of(option);
    if (value.find('|') == std::string_view::npos) return {};
    if (value.starts_with('[')) value = value.substr(1, value.size() - 2);
    return split(value, '|');
}

const Option* find_option(std::string_view name) {
    const Option* found = nullptr;
    each_option([&](const Option& option) {
        if (std::ranges::count(names_of(option), name) > 0) found = &option;
    });
    return found;
}

}  // namespace clvotess
