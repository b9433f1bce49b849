// Volume, centroid and areas of the faces of a finished cell, from its planes and vertices alone. Feet of the seed on a
// face's plane (r_a) and on an edge's line (r_ab) split the cell into tetrahedra (seed, r_a, r_ab, vertex), signed, six
// a vertex:
//     6 V = sum over vertices (a,b,c) and their edges (a,b), (b,c), (c,a) of det(r_a - r_b, r_ab, vertex) .
//
// and the area of face a is 1/2 sum over its vertices and edges of +- n_a . (r_ab x vertex) / |n_a|.
//
// A term is right to u R^3 (45 / sin^2(a,b) + 60 condition + 10), R the farthest vertex.
//
// The areas are right to volume_error 3 / R altogether: relative to the surface that is better than the volume, which
// is at most surface R / 3.
//
// Needs want_geometry, geometry_real, geometry_unit and quantum.

struct Moments {
    geometry_real sum, x, y, z;     // six volumes, and 24 times their centroids
    geometry_real error, farthest;  // farthest: squared
};

geometry_real volume, centroid_x, centroid_y, centroid_z, volume_error;

// Adds the tetrahedra of the vertex of three planes n.x = h. areas: what it adds to the areas of the three faces.
void add_corner(geometry_real nx[3], geometry_real ny[3], geometry_real nz[3], geometry_real h[3], inout Moments all,
                out geometry_real areas[3]) {
    geometry_real nn[3];
    for (int k = 0; k < 3; ++k) {
        nn[k] = nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k];
        areas[k] = geometry_real(0);
    }
    // t[k] = n[k] x n[k+1], along the edge of both planes.
    geometry_real tx[3], ty[3], tz[3];
    for (int k = 0; k < 3; ++k) {
        const int l = k == 2 ? 0 : k + 1;
        tx[k] = ny[k] * nz[l] - nz[k] * ny[l];
        ty[k] = nz[k] * nx[l] - nx[k] * nz[l];
        tz[k] = nx[k] * ny[l] - ny[k] * nx[l];
    }
    const geometry_real det = nx[0] * tx[1] + ny[0] * ty[1] + nz[0] * tz[1];
    const geometry_real inverse = geometry_real(1) / det;
    const geometry_real x = (h[0] * tx[1] + h[1] * tx[2] + h[2] * tx[0]) * inverse;
    const geometry_real y = (h[0] * ty[1] + h[1] * ty[2] + h[2] * ty[0]) * inverse;
    const geometry_real z = (h[0] * tz[1] + h[1] * tz[2] + h[2] * tz[0]) * inverse;
    all.farthest = max(all.farthest, x * x + y * y + z * z);
    all.error += geometry_real(180) * sqrt(nn[0] * nn[1] * nn[2]) * inverse + geometry_real(30);
    for (int k = 0; k < 3; ++k) {
        const int l = k == 2 ? 0 : k + 1;
        const geometry_real tt = tx[k] * tx[k] + ty[k] * ty[k] + tz[k] * tz[k];
        const geometry_real over = geometry_real(1) / tt;
        // r_ab = (h_a (n_b x t) + h_b (t x n_a)) / |t|^2
        const geometry_real ex =
            (h[k] * (ny[l] * tz[k] - nz[l] * ty[k]) + h[l] * (ty[k] * nz[k] - tz[k] * ny[k])) * over;
        const geometry_real ey =
            (h[k] * (nz[l] * tx[k] - nx[l] * tz[k]) + h[l] * (tz[k] * nx[k] - tx[k] * nz[k])) * over;
        const geometry_real ez =
            (h[k] * (nx[l] * ty[k] - ny[l] * tx[k]) + h[l] * (tx[k] * ny[k] - ty[k] * nx[k])) * over;
        const geometry_real cx = ey * z - ez * y, cy = ez * x - ex * z, cz = ex * y - ey * x;
        const geometry_real foot_a = h[k] / nn[k], foot_b = h[l] / nn[l];
        const geometry_real doubled_a = nx[k] * cx + ny[k] * cy + nz[k] * cz;  // area times |n|
        const geometry_real doubled_b = nx[l] * cx + ny[l] * cy + nz[l] * cz;
        const geometry_real part_a = foot_a * doubled_a;
        const geometry_real part_b = foot_b * doubled_b;
        if (want_geometry == 2u) {
            areas[k] += geometry_real(0.5) * doubled_a / sqrt(nn[k]);
            areas[l] -= geometry_real(0.5) * doubled_b / sqrt(nn[l]);
        }
        const geometry_real part = part_a - part_b;
        all.sum += part;
        all.x += part * (ex + x) + part_a * foot_a * nx[k] - part_b * foot_b * nx[l];
        all.y += part * (ey + y) + part_a * foot_a * ny[k] - part_b * foot_b * ny[l];
        all.z += part * (ez + z) + part_a * foot_a * nz[k] - part_b * foot_b * nz[l];
        all.error += geometry_real(45) * nn[k] * nn[l] * over;
    }
}

void conclude(Moments all) {
    const geometry_real radius = sqrt(all.farthest);
    volume = all.sum / geometry_real(6);
    // A tetrahedron's centroid is a quarter of the sum of its corners.
    const geometry_real over = geometry_real(0.25) / all.sum;
    centroid_x = all.x * over;
    centroid_y = all.y * over;
    centroid_z = all.z * over;
    volume_error = (geometry_unit + geometry_real(8) * geometry_real(quantum)) * all.error * radius * radius * radius /
                   geometry_real(3);
}
