// Measures a cell of a subgroup: a lane measures at its vertices, and the sums are over all lanes. The store of
// candidates, which is not needed any more, takes the planes in the precision of geometry.
//
// Needs what lib/subgroup_cell.glsl, lib/corner.glsl and lib/relative.glsl define.

#ifdef GEOMETRY_FLOAT64
#define PUT_NUMBER(array, i, number)                              \
    {                                                             \
        const uvec2 words = unpackDouble2x32(number);             \
        array[SUBGROUP_STORE * SUBGROUP + (i)] = words.x;    \
        array[SUBGROUP_STORE * SUBGROUP + (i) + 32] = words.y; \
    }
#define GET_NUMBER(array, i)                                              \
    packDouble2x32(uvec2(array[SUBGROUP_STORE * SUBGROUP + (i)],     \
                         array[SUBGROUP_STORE * SUBGROUP + (i) + 32]))
#else
#define PUT_NUMBER(array, i, number) array[SUBGROUP_STORE * SUBGROUP + (i)] = floatBitsToUint(number);
#define GET_NUMBER(array, i) uintBitsToFloat(array[SUBGROUP_STORE * SUBGROUP + (i)])
#endif

#define VERTEX_LIST(i) scratch[SUBGROUP_SCRATCH * SUBGROUP + (i)]
const int planes_of_lane = (SUBGROUP_PLANES + lanes - 1) / lanes;

void share_exact_planes(uint used) {
    share();
    for (uint p = lane; p < SUBGROUP_PLANES; p += uint(lanes)) {
        if (((used >> p) & 1u) == 0u) continue;
        const int id = id_of(p);
        const Plane rounded = plane_at(p);
        geometry_real x = geometry_real(rounded.x), y = geometry_real(rounded.y), z = geometry_real(rounded.z), h;
        if (id < 0) {
            h = wall_distance(-1 - id);
        } else {
            x = geometry_difference(seeds_x[id], px);
            y = geometry_difference(seeds_y[id], py);
            z = geometry_difference(seeds_z[id], pz);
            h = (x * x + y * y + z * z) / geometry_real(2);
        }
        PUT_NUMBER(candidate_key, p, x)
        PUT_NUMBER(candidate_key, p + 64u, y)
        PUT_NUMBER(candidate_seed, p, z)
        PUT_NUMBER(candidate_seed, p + 64u, h)
    }
    share();
}

geometry_real area_of(uint plane) {
    return GET_NUMBER(candidate_key, plane);
}

// Afterwards the areas take the place of the planes.
void measure_cell(uint used, uint vertices) {
    share_exact_planes(used);
    uint listed = 0u;
    [[unroll]] for (int s = 0; s < slots; ++s) {
        const bool is_alive = (alive & (1u << s)) != 0u;
        uint count;
        const uint at = listed + rank_among(is_alive, count);
        if (is_alive) VERTEX_LIST(at) = vertex_planes[s];
        listed += count;
    }
    share();
    const geometry_real zero = geometry_real(0);
    Moments all = Moments(zero, zero, zero, zero, zero, zero);
    geometry_real areas_of_lane[planes_of_lane];
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) areas_of_lane[i] = zero;
    for (uint first = 0u; first < vertices; first += uint(lanes)) {
        geometry_real nx[3], ny[3], nz[3], h[3], parts[3];
        uint planes = 0xffffffu;  // none
        if (first + lane < vertices) {
            planes = VERTEX_LIST(first + lane);
            for (int k = 0; k < 3; ++k) {
                const uint p = plane_of(planes, k);
                nx[k] = GET_NUMBER(candidate_key, p);
                ny[k] = GET_NUMBER(candidate_key, p + 64u);
                nz[k] = GET_NUMBER(candidate_seed, p);
                h[k] = GET_NUMBER(candidate_seed, p + 64u);
            }
            add_corner(nx, ny, nz, h, all, parts);
        }
        if (want_geometry != 2u) continue;
        for (uint rest = used; rest != 0u; rest &= rest - 1u) {
            const uint p = uint(findLSB(rest));
            geometry_real mine = zero;
            for (int k = 0; k < 3; ++k)
                if (plane_of(planes, k) == p) mine = parts[k];
            const geometry_real area = sum_numbers(mine);
            [[unroll]] for (int i = 0; i < planes_of_lane; ++i)
                if (p == uint(i * lanes) + lane) areas_of_lane[i] += area;
        }
    }
    all.sum = sum_numbers(all.sum);
    all.x = sum_numbers(all.x);
    all.y = sum_numbers(all.y);
    all.z = sum_numbers(all.z);
    all.error = sum_numbers(all.error);
    all.farthest = largest_number(all.farthest);
    conclude(all);
    if (want_geometry != 2u) return;
    share();
    [[unroll]] for (int i = 0; i < planes_of_lane; ++i) {
        const uint p = uint(i * lanes) + lane;
        if (p < SUBGROUP_PLANES) PUT_NUMBER(candidate_key, p, areas_of_lane[i])
    }
    share();
}
