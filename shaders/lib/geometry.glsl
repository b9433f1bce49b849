// Measures a cell in private memory.
// Needs what lib/cell.glsl, lib/corner.glsl and lib/relative.glsl define.

geometry_real exact_x[most_planes], exact_y[most_planes], exact_z[most_planes];
geometry_real area[most_planes];  // when want_geometry is 2

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
    const geometry_real zero = geometry_real(0);
    Moments all = Moments(zero, zero, zero, zero, zero, zero);
    for (int v = 0; v < vertex_count; ++v) {
        geometry_real nx[3], ny[3], nz[3], h[3], areas[3];
        for (int k = 0; k < 3; ++k) {
            const uint p = plane_of(vertex_planes[v], k);
            nx[k] = exact_x[p];
            ny[k] = exact_y[p];
            nz[k] = exact_z[p];
            h[k] = plane_id[p] < 0 ? wall_distance(-1 - plane_id[p])
                                   : (nx[k] * nx[k] + ny[k] * ny[k] + nz[k] * nz[k]) / geometry_real(2);
        }
        add_corner(nx, ny, nz, h, all, areas);
        if (want_geometry == 2u)
            for (int k = 0; k < 3; ++k) area[plane_of(vertex_planes[v], k)] += areas[k];
    }
    conclude(all);
}
