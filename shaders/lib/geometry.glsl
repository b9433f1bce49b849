// Volume, centroid and areas of the faces of a finished cell, from its planes and vertices alone. Feet of the seed on a face's plane (r_a)
// and on an edge's line (r_ab) split the cell into tetrahedra (seed, r_a, r_ab, vertex), signed, six a vertex:
//     6 V = sum over vertices (a,b,c) and their edges (a,b), (b,c), (c,a) of det(r_a - r_b, r_ab, vertex) .
//
// and the area of face a is 1/2 sum over its vertices and edges of +- n_a . (r_ab x vertex) / |n_a|.
//
// A term is right to u R^3 (45 / sin^2(a,b) + 60 condition + 10), R the farthest vertex.
//
// The areas are right to volume_error 3 / R altogether: relative to the surface that is better than the volume, which
// is at most surface R / 3.
//
// Needs want_geometry, geometry_real, geometry_unit, geometry_difference() and what lib/cell.glsl defines.

geometry_real exact_x[most_planes], exact_y[most_planes], exact_z[most_planes];
geometry_real area[most_planes];  // when want_geometry is 2
geometry_real volume, centroid_x, centroid_y, centroid_z, volume_error;

void measure_cell() {
    // Planes anew, in this precision.
    for (int w = 0; w < plane_words; ++w)
        for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u) {
            const int p = 32 * w + findLSB(rest);
            area[p] = geometry_real(0);
            exact_x[p] = geometry_real(plane_x[p]);
            exact_y[p] = geometry_real(plane_y[p]);
            exact_z[p] = geometry_real(plane_z[p]);
            if (plane_id[p] < 0) continue;
            const uint q = uint(plane_id[p]);
            exact_x[p] = geometry_difference(seeds_x[q], px);
            exact_y[p] = geometry_difference(seeds_y[q], py);
            exact_z[p] = geometry_difference(seeds_z[q], pz);
        }
    geometry_real sum = geometry_real(0), error = geometry_real(0), farthest = geometry_real(0);
    geometry_real sum_x = geometry_real(0), sum_y = geometry_real(0), sum_z = geometry_real(0);
    for (int v = 0; v < vertex_count; ++v) {
        geometry_real nx[3], ny[3], nz[3], h[3], nn[3];
        for (int k = 0; k < 3; ++k) {
            const uint p = plane_of(vertex_planes[v], k);
            nx[k] = exact_x[p];
            ny[k] = exact_y[p];
            nz[k] = exact_z[p];
            nn[k] = nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k];
            h[k] = plane_id[p] < 0 ? wall_distance(-1 - plane_id[p]) : nn[k] / geometry_real(2);
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
        farthest = max(farthest, x * x + y * y + z * z);
        error += geometry_real(180) * sqrt(nn[0] * nn[1] * nn[2]) * inverse + geometry_real(30);
        for (int k = 0; k < 3; ++k) {
            const int l = k == 2 ? 0 : k + 1;
            const geometry_real tt = tx[k] * tx[k] + ty[k] * ty[k] + tz[k] * tz[k];
            const geometry_real over = geometry_real(1) / tt;
            // r_ab = (h_a (n_b x t) + h_b (t x n_a)) / |t|^2
            const geometry_real ex = (h[k] * (ny[l] * tz[k] - nz[l] * ty[k]) + h[l] * (ty[k] * nz[k] - tz[k] * ny[k])) * over;
            const geometry_real ey = (h[k] * (nz[l] * tx[k] - nx[l] * tz[k]) + h[l] * (tz[k] * nx[k] - tx[k] * nz[k])) * over;
            const geometry_real ez = (h[k] * (nx[l] * ty[k] - ny[l] * tx[k]) + h[l] * (tx[k] * ny[k] - ty[k] * nx[k])) * over;
            const geometry_real cx = ey * z - ez * y, cy = ez * x - ex * z, cz = ex * y - ey * x;
            const geometry_real foot_a = h[k] / nn[k], foot_b = h[l] / nn[l];
            const geometry_real doubled_a = nx[k] * cx + ny[k] * cy + nz[k] * cz;  // area times |n|
            const geometry_real doubled_b = nx[l] * cx + ny[l] * cy + nz[l] * cz;
            const geometry_real part_a = foot_a * doubled_a;
            const geometry_real part_b = foot_b * doubled_b;
            if (want_geometry == 2u) {
                area[plane_of(vertex_planes[v], k)] += geometry_real(0.5) * doubled_a / sqrt(nn[k]);
                area[plane_of(vertex_planes[v], l)] -= geometry_real(0.5) * doubled_b / sqrt(nn[l]);
            }
            const geometry_real part = part_a - part_b;
            sum += part;
            sum_x += part * (ex + x) + part_a * foot_a * nx[k] - part_b * foot_b * nx[l];
            sum_y += part * (ey + y) + part_a * foot_a * ny[k] - part_b * foot_b * ny[l];
            sum_z += part * (ez + z) + part_a * foot_a * nz[k] - part_b * foot_b * nz[l];
            error += geometry_real(45) * nn[k] * nn[l] * over;
        }
    }
    const geometry_real radius = sqrt(farthest);
    volume = sum / geometry_real(6);
    // A tetrahedron's centroid is a quarter of the sum of its corners.
    const geometry_real over = geometry_real(0.25) / sum;
    centroid_x = sum_x * over;
    centroid_y = sum_y * over;
    centroid_z = sum_z * over;
    volume_error = (geometry_unit + geometry_real(8) * geometry_real(quantum)) * error * radius * radius * radius / geometry_real(3);
}
