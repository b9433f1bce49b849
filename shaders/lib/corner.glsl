// Volume, centroid and areas of the faces of a finished cell, from its planes and vertices alone. Feet of the seed on a
// face's plane (r_a = foot_a n_a) and on an edge's line (r_ab) split the cell into tetrahedra (seed, r_a, r_ab, vertex),
// signed, six a vertex. With t = n_a x n_b along the edge and
//     r_ab = alpha n_a + beta n_b,  alpha = (h_a |n_b|^2 - h_b n_a.n_b) / |t|^2,  beta = (h_b |n_a|^2 - h_a n_a.n_b) / |t|^2
// both on the edge (a,b) of the vertex X have
//     6 V = (foot_a beta + foot_b alpha) X.t ,
// and add beta X.t / (2 |n_a|) to the area of face a, alpha X.t / (2 |n_b|) to that of b.
//
// R the farthest vertex, u the unit roundoff: alpha |n_a| <= R / sin(a,b) is right to 41u R / sin^2, X.t to
// |n_a||n_b| (sin |x - X| + 9u R), X to u R (51 condition + 6) as in lib/filter.glsl; so 6 V of an edge is right to
//     u R^3 (100 / sin^2(a,b) + 102 condition + 50) ,
// the last for its sum with all others. The areas are right to volume_error 3 / R altogether: relative to the surface
// that is better than the volume, which is at most surface R / 3.
//
// Needs want_geometry, quantum, lib/number.glsl and lib/relative.glsl.

struct ExactPlane {
    Vector n;
    Number foot;  // n.x = foot |n|^2; of bisectors 1/2
};

ExactPlane exact_wall(uint i) {
    const Number zero = number(0.0), side = number((i & 1u) != 0u ? 1.0 : -1.0);
    const uint axis = i / 2u;
    const uvec2 p = axis == 0u ? px : (axis == 1u ? py : pz);
    return ExactPlane(Vector(axis == 0u ? side : zero, axis == 1u ? side : zero, axis == 2u ? side : zero),
                      (i & 1u) != 0u ? exact_difference(push.extent[axis], p) : exact_difference(p, uvec2(0)));
}

ExactPlane exact_bisector(uint q) {
    return ExactPlane(Vector(exact_difference(seeds_x[q], px), exact_difference(seeds_y[q], py),
                             exact_difference(seeds_z[q], pz)),
                      number(0.5));
}

struct Moments {
    Number sum;             // six volumes
    Vector first;           // and 24 times their centroids
    float error, farthest;  // error in u R^3; farthest: squared
};

Number volume;
Vector mass_center;
float volume_error;
bool is_in_range;

Moments no_moments() {
    const Number zero = number(0.0);
    return Moments(zero, Vector(zero, zero, zero), 0.0, 0.0);
}

// Adds the tetrahedra of the vertex of three planes. areas: what it adds to the areas of their faces.
void add_corner(ExactPlane plane[3], inout Moments all, out Number areas[3]) {
    Number square[3], h[3], of_normal[3];
    float norm[3];
    for (int k = 0; k < 3; ++k) {
        square[k] = dot(plane[k].n, plane[k].n);
        h[k] = times(plane[k].foot, square[k]);
        norm[k] = sqrt(rounded(square[k]));
        of_normal[k] = areas[k] = number(0.0);
    }
    Vector t[3];
    for (int k = 0; k < 3; ++k) t[k] = cross(plane[k].n, plane[k == 2 ? 0 : k + 1].n);
    const Number inverse_det = reciprocal(dot(plane[0].n, t[1]));
    const Vector vertex =
        times(plus(plus(times(t[1], h[0]), times(t[2], h[1])), times(t[0], h[2])), inverse_det);
    const vec3 near_vertex = vec3(rounded(vertex.x), rounded(vertex.y), rounded(vertex.z));
    all.farthest = max(all.farthest, dot(near_vertex, near_vertex));
    all.error += 306.0 * (norm[0] * norm[1] * norm[2] * rounded(inverse_det)) + 150.0;

    Number of_vertex = number(0.0);
    for (int k = 0; k < 3; ++k) {
        const int l = k == 2 ? 0 : k + 1;
        const Number over = reciprocal(dot(t[k], t[k])), both = dot(plane[k].n, plane[l].n);
        const Number alpha = times(minus(times(h[k], square[l]), times(h[l], both)), over);
        const Number beta = times(minus(times(h[l], square[k]), times(h[k], both)), over);
        const Number along = dot(vertex, t[k]);
        const Number area_k = times(beta, along), area_l = times(alpha, along);  // twice, and times |n|
        const Number part_k = times(plane[k].foot, area_k), part_l = times(plane[l].foot, area_l);
        const Number part = plus(part_k, part_l);
        of_vertex = plus(of_vertex, part);
        // Of the sum of the corners r_a, r_ab and X, in terms of n_a, n_b and X.
        of_normal[k] = plus(of_normal[k], plus(times(part, alpha), times(part_k, plane[k].foot)));
        of_normal[l] = plus(of_normal[l], plus(times(part, beta), times(part_l, plane[l].foot)));
        if (want_geometry == 2u) {
            areas[k] = plus(areas[k], area_k);
            areas[l] = plus(areas[l], area_l);
        }
        const float sines = norm[k] * norm[l];
        all.error += 100.0 * sines * sines * rounded(over);
    }
    all.sum = plus(all.sum, of_vertex);
    all.first = plus(all.first, times(vertex, of_vertex));
    for (int k = 0; k < 3; ++k) {
        all.first = plus(all.first, times(plane[k].n, of_normal[k]));
        if (want_geometry == 2u) areas[k] = times(times(areas[k], number(0.5)), reciprocal(root(square[k])));
    }
}

void conclude(Moments all) {
    volume = times(all.sum, reciprocal(number(6.0)));
    // A tetrahedron's centroid is a quarter of the sum of its corners.
    mass_center = times(all.first, times(reciprocal(all.sum), number(0.25)));
    const float radius = sqrt(all.farthest);
    is_in_range = all.farthest < farthest_of_range;
    // Some more than the bound, for the roundings in it.
    volume_error = (number_unit + 8.0 * float(quantum)) * all.error * radius * radius * radius * 0.334;
}

// Areas of faces of next to no size may come out below zero.
Number not_negative(Number area) {
    return rounded(area) < 0.0 ? number(0.0) : area;
}

bool is_measured(float tolerance) {
    return volume_error <= tolerance * rounded(volume) && is_in_range;
}
