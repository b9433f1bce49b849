// gradient: the product of the derivatives of a frame's volumes, centroids and areas with given vectors.
//
// A work-group makes the four numbers of one seed, from the planes of its row and the walls: the derivatives of a number
// L by its place and its weight. The faces of the seed are those that move. Relative to the seed, let face a be
// n_a.y = h_a, where n_a leads to the neighbor. When the seed moves by d and its weight grows by w, a point y of each
// face moves so that n_a.dy = y.d + w/2 (bindings/python/pyvotess/_motion.py has the same formulas for both seeds).
//
// Volumes and centroids: L changes by the integral over face a of q(y) (y.d + w/2) / |n_a|, where q is the difference of
// c + s.y (gradient_cells.comp) of both cells. The edges of the face split it into signed triangles with the foot of the
// seed on its plane. The middles of a triangle's sides integrate squares exactly.
//
// Areas: L is the sum of A times what is given for both entries of a face. Faces change by the motion of their edges.
// The edge of faces a and b, along t = n_a x n_b, moves by v (y.d + w/2), where n_a.v = n_b.v = 1, and n_b.v = 0 where b
// is a wall. Three faces meet there: a, b, and that of the two neighbors. Each grows by the part of this along its
// outward normal in its plane: those of t x n_a, n_b x t and t x (n_b - n_a). Where both neighbors are images of the seed
// itself, all cells at the edge move together, and it moves by d. There may be four of them, as in a box with right angles.
// Each is once the cell here, and adds half of the growth of its two faces at the edge.
//
// Lengths are in units of the cell: powers of two, near the distance of a neighbor. All numbers are float64: float32
// loses the edges of narrow cells.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "clip/wall_distance.glsl"
#include "invocations/index.glsl"
#include "invocations/loop_guard.glsl"
#include "numbers/int64.glsl"
#include "shared/gradient.h"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { GradientPush push; };
layout(std430, binding = BINDING_POINTS) readonly buffer Points { uvec2 points[]; };
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State {
    RunState state;
    WallPlane walls[];
};
layout(std430, binding = BINDING_PART_OFFSETS) readonly buffer PartOffsets { uint part_offsets[]; };
layout(std430, binding = BINDING_SLICE_ROWS) readonly buffer SliceRows { int slice_rows[]; };
layout(std430, binding = BINDING_SLICE_SHIFTS) readonly buffer SliceShifts { uint slice_shifts[]; };
layout(std430, binding = BINDING_SLOPES) readonly buffer Slopes { dvec4 slopes[]; };
layout(std430, binding = BINDING_GIVEN_AREAS) readonly buffer GivenAreas { float given_areas[]; };
layout(std430, binding = BINDING_GRADIENT) writeonly buffer Gradient { uint gradient[]; };

const uint lanes = GRADIENT_LANES, shared_planes = 128u;
const double beyond_all = 1.0e30LF;
const double parallel = 1.0e-24LF;  // squared sine of an angle below which planes have no edge
const double one_edge = 1.0e-10LF;  // of planes whose distance or angle is less, relative to the cell

struct Plane {
    dvec3 n;
    double h;
};

shared Plane stored[shared_planes];
shared double sums[4u * lanes];
shared uint is_unknown;  // 1: the driver ended loops early

uint cell;
uint first, neighbors;  // entries of the row that are seeds: its faces 0, 1, ...; walls are planes behind them
uint planes;
uvec2 place[3];
float scale;  // units to units of the cell
double length_of_unit;
dvec3 by_point = dvec3(0.0);
double by_weight = 0.0LF;  // twice

bool has(uint bit) {
    return (push.bits & bit) != 0u;
}

// Returns a number in two's complement.
double whole(uvec2 d) {
    const uvec2 m = magnitude64(d);
    const double size = double(m.y) * 4294967296.0LF + double(m.x);
    return is_negative(d) ? -size : size;
}

double power_of_two(int exponent) {
    return packDouble2x32(uvec2(0u, uint(clamp(exponent + 1023, 0, 2047)) << 20));
}

uint seed_of(uint face) {
    return uint(slice_rows[first + face]);
}
uint shift_of(uint face) {
    return has(GRADIENT_SHIFTS) ? slice_shifts[first + face] : 0u;
}
// Returns a - b of shifts, each int8 x y z 0.
uint minus_shift(uint a, uint b) {
    const uvec3 d = uvec3(a, a >> 8, a >> 16) - uvec3(b, b >> 8, b >> 16) & 0xffu;
    return d.x | d.y << 8 | d.z << 16;
}

// Returns the way to a neighbor in units.
uvec2[3] way_to(uint face) {
    uvec2 d[3];
    const uint seed = seed_of(face), shift = shift_of(face);
    for (uint k = 0u; k < 3u; ++k) {
        d[k] = subtract64(points[k * push.total + seed], place[k]);
        if (shift == 0u) continue;
        for (uint v = 0u; v < 3u; ++v)
            d[k] = add64(d[k], times64(bitfieldExtract(int(shift), int(8u * v), 8), push.vector[3u * v + k]));
    }
    return d;
}

Plane bisector(uint face) {
    const uvec2 d[3] = way_to(face);
    const dvec3 n = dvec3(whole(d[0]), whole(d[1]), whole(d[2])) * double(scale);
    double twice = dot(n, n);
    if (has(GRADIENT_WEIGHTS)) {
        const uint at = 3u * push.total;
        const double lighter = whole(subtract64(points[at + cell], points[at + seed_of(face)])) * double(scale);
        twice += lighter * (double(scale) * power_of_two(state.weight_exponent));
    }
    return Plane(n, 0.5LF * twice);
}

// Returns the number of wall i: rows list it as -1 less the number.
uint wall_number(uint i) {
    if (has(GRADIENT_OBLIQUE)) return i;
    return 2u * (push.bits >> (GRADIENT_AXES_SHIFT + (i & ~1u)) & 3u) + (i & 1u);
}

// Returns wall i as a plane; one that cuts nothing has no normal.
Plane wall_plane(uint i) {
    if (has(GRADIENT_OBLIQUE)) {
        const WallPlane wall = walls[i];
        if (!(wall.rough[3] < UNBOUNDED)) return Plane(dvec3(0.0), 1.0LF);
        const dvec3 n = dvec3(whole(wall.normal[0]), whole(wall.normal[1]), whole(wall.normal[2]));
        const uvec2 distance = whole_wall_distance(fine_wall_distance(wall, place[0], place[1], place[2]));
        return Plane(n * power_of_two(-WALL_BITS), whole(distance) * double(scale));
    }
    const uint axis = wall_number(i) / 2u;
    const bool is_upper = (i & 1u) != 0u;
    dvec3 n = dvec3(0.0);
    n[axis] = is_upper ? 1.0LF : -1.0LF;
    return Plane(n, whole(is_upper ? subtract64(push.extent[axis], place[axis]) : place[axis]) * double(scale));
}

Plane make_plane(uint i) {
    return i < neighbors ? bisector(i) : wall_plane(i - neighbors);
}
Plane plane_at(uint i) {
    if (i < shared_planes) return stored[i];
    return make_plane(i);
}

// Adds the integrals over the triangle of an edge and the foot of the seed on its face. area: signed.
void add_triangle(uint face, Plane a, double area, dvec3 begin, dvec3 end) {
    const dvec4 own = slopes[cell], other = slopes[seed_of(face)];
    const double square = length_of_unit * length_of_unit, cube = square * length_of_unit;
    const dvec3 other_slope = other.xyz * cube, slope = own.xyz * cube - other_slope;
    const double constant = (own.w - other.w) * square + dot(other_slope, a.n);
    const dvec3 foot = a.n * (a.h / dot(a.n, a.n));
    const dvec3 middles[3] = dvec3[3](0.5LF * (foot + begin), 0.5LF * (begin + end), 0.5LF * (end + foot));
    const double third = area / (3.0LF * length(a.n));
    for (int k = 0; k < 3; ++k) {
        const double value = third * (constant + dot(slope, middles[k]));
        by_point += value * middles[k];
        by_weight += value;
    }
}

// Returns what is given for the area of an entry, 0 where the row has no such entry.
double given_area(uint row, int id, uint shift) {
    const uint end = part_offsets[row + 1u];
    for (uint e = part_offsets[row]; e < end; ++e)
        if (slice_rows[e] == id && (!has(GRADIENT_SHIFTS) || slice_shifts[e] == shift)) return double(given_areas[e]);
    return 0.0LF;
}

// Returns whether no other plane through the edge of two faces takes the place of one of them. t: along the edge.
bool both_have_the_edge(uint face, uint other, Plane a, Plane b, dvec3 t, dvec3 begin) {
    for (uint i = 0u; i < planes; ++i) {
        if (i == face || i == other) continue;
        const Plane c = plane_at(i);
        const double size = length(c.n);
        if (abs(dot(c.n, t)) > one_edge * size * length(t) || abs(c.h - dot(c.n, begin)) > one_edge * size) continue;
        // c.n is a sum of multiples of a.n and b.n. If both are positive, c only touches the cell.
        if (min(dot(cross(c.n, b.n), t), dot(cross(a.n, c.n), t)) < -one_edge * dot(t, t)) return false;
    }
    return true;
}

// Adds the growth of the three faces at an edge. t: along it.
void add_edge(uint face, uint other, Plane a, Plane b, dvec3 t, dvec3 begin, dvec3 end) {
    const bool is_wall = other >= neighbors;
    const uint seed = seed_of(face), shift = shift_of(face);
    const bool all_move = !is_wall && seed == cell && seed_of(other) == cell;
    if (all_move && !both_have_the_edge(face, other, a, b, t, begin)) return;
    double of_a = double(given_areas[first + face]) + given_area(seed, int(cell), minus_shift(0u, shift)), of_b, of_both;
    if (is_wall) {
        const int id = -1 - int(wall_number(other - neighbors));
        of_b = given_area(cell, id, 0u);
        of_both = given_area(seed, id, 0u);
    } else {
        const uint other_seed = seed_of(other), other_shift = shift_of(other);
        of_b = double(given_areas[first + other]) + given_area(other_seed, int(cell), minus_shift(0u, other_shift));
        of_both = given_area(seed, int(other_seed), minus_shift(other_shift, shift)) +
                  given_area(other_seed, int(seed), minus_shift(shift, other_shift));
    }
    const dvec3 from_a = cross(t, a.n), from_b = cross(b.n, t);
    dvec3 growth = from_a * (of_a / length(a.n)) + from_b * (of_b / length(b.n));
    if (all_move) {
        by_point += growth * (0.5LF * length_of_unit * length(end - begin) / length(t));
        return;
    }
    // The face of the two neighbors, or beyond a wall, of which it is a part, the neighbor's.
    growth -= is_wall ? from_b * (of_both / length(b.n)) : (from_a + from_b) * (of_both / length(b.n - a.n));
    const double squared = dot(t, t), both = dot(a.n, b.n), square_a = dot(a.n, a.n), square_b = dot(b.n, b.n);
    const double moves_b = is_wall ? 0.0LF : 1.0LF;
    const dvec3 v = (a.n * (square_b - moves_b * both) + b.n * (moves_b * square_a - both)) / squared;
    const double value = length_of_unit * dot(v, growth) * length(end - begin) / sqrt(squared);
    by_point += value * 0.5LF * (begin + end);
    by_weight += value;
}

// Adds what moves with the edge of face a and plane b, if there is one.
void add(uint face, uint other) {
    const Plane a = plane_at(face), b = plane_at(other);
    const dvec3 t = cross(a.n, b.n);
    const double squared = dot(t, t), both = dot(a.n, b.n), square_a = dot(a.n, a.n), square_b = dot(b.n, b.n);
    if (!(squared > parallel * square_a * square_b)) return;
    // The line of both planes, from the foot of the seed on.
    const dvec3 foot = (a.n * (a.h * square_b - b.h * both) + b.n * (b.h * square_a - a.h * both)) / squared;
    double from = -beyond_all, to = beyond_all;
    for (uint i = 0u; i < planes && from < to; ++i) {
        if (i == face || i == other) continue;
        const Plane c = plane_at(i);
        const double along = dot(c.n, t), room = c.h - dot(c.n, foot);
        if (along > 0.0LF)
            to = min(to, room / along);
        else if (along < 0.0LF)
            from = max(from, room / along);
        else if (room < 0.0LF)
            to = from;
    }
    if (!(from < to)) return;
    const dvec3 begin = foot + from * t, end = foot + to * t;
    if (has(GRADIENT_OF_VOLUMES | GRADIENT_OF_CENTROIDS)) {
        const double half_length = 0.5LF * (to - from);  // of a vector t
        add_triangle(face, a, half_length * dot(foot, cross(t, a.n)) / sqrt(square_a), begin, end);
        if (other < neighbors)
            add_triangle(other, b, half_length * dot(foot, cross(b.n, t)) / sqrt(square_b), begin, end);
    }
    if (has(GRADIENT_OF_AREAS)) add_edge(face, other, a, b, t, begin, end);
}

void put(uint number, double value) {
    if (!has(GRADIENT_FLOAT64)) {
        gradient[number] = floatBitsToUint(float(value));
        return;
    }
    const uvec2 words = unpackDouble2x32(value);
    gradient[2u * number] = words.x;
    gradient[2u * number + 1u] = words.y;
}

void put_unknown(uint number) {
    if (!has(GRADIENT_FLOAT64)) {
        gradient[number] = 0x7fc00000u;
        return;
    }
    gradient[2u * number] = 0u;
    gradient[2u * number + 1u] = GRADIENT_UNKNOWN;
}

void main() {
    cell = linear_group();
    const uint lane = gl_LocalInvocationID.x;
    if (cell >= push.count) return;
    const uint end = part_offsets[cell + 1u];
    first = part_offsets[cell];
    while (first < end && slice_rows[first] < 0) ++first;
    neighbors = end - first;
    if (neighbors == 0u) return;
    for (uint k = 0u; k < 3u; ++k) place[k] = points[k * push.total + cell];
    const uvec2 way[3] = way_to(0u);
    const uvec2 bits = magnitude64(way[0]) | magnitude64(way[1]) | magnitude64(way[2]);
    const int exponent = bits.y != 0u ? 32 + findMSB(bits.y) : max(findMSB(bits.x), 0);
    scale = uintBitsToFloat(uint(127 - exponent) << 23);
    length_of_unit = power_of_two(exponent - push.shift);
    planes = neighbors + push.walls;

    is_unknown = 0u;
    for (uint i = lane; i < min(planes, shared_planes); i += lanes) stored[i] = make_plane(i);
    barrier();
    // Each pair of faces once, then each face with each wall.
    const uint pairs = neighbors * (neighbors - 1u) / 2u, all = pairs + neighbors * push.walls;
    for (uint i = lane; i < all; i += lanes) {
        const uint face = (i < pairs ? i : i - pairs) % neighbors, turn = (i < pairs ? i : i - pairs) / neighbors;
        add(face, i < pairs ? (face + 1u + turn) % neighbors : neighbors + turn);
    }
    for (uint k = 0u; k < 3u; ++k) sums[k * lanes + lane] = by_point[k];
    sums[3u * lanes + lane] = by_weight;
    if (loops_were_cut_short(planes + 1u)) is_unknown = 1u;
    barrier();
    if (lane >= 4u) return;
    double sum = 0.0LF;
    for (uint i = 0u; i < lanes; ++i) sum += sums[lane * lanes + i];
    const uint number = lane < 3u ? 3u * cell + lane : push.weights_at + cell;
    if (is_unknown != 0u || loops_were_cut_short(planes + 1u))
        put_unknown(number);
    else
        put(number, lane < 3u ? sum : 0.5LF * sum / length_of_unit);
}
