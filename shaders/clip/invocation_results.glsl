// Writes a cell of an invocation. The .comp declares `push`, with volume_tolerance, neighbors and row_stride, before.
#ifndef VOTESS_CLIP_INVOCATION_RESULTS_GLSL
#define VOTESS_CLIP_INVOCATION_RESULTS_GLSL

#include "clip/cell_results.glsl"
#include "clip/invocation_cell.glsl"
#ifdef DECIDES_TIES
#include "clip/invocation_ties.glsl"
#endif
#include "invocations/loop_guard.glsl"
#include "kept/kept_column.glsl"
#include "measure/invocation_measure.glsl"

void finish(uint slot, uint cell, uint exponent) {
    uint length = 0u, faces = 0u, vertices = uint(vertex_count);
    if (status == STATUS_CERTIFIED) {
        note_planes_in_use();
        for (int w = 0; w < plane_words; ++w) faces += uint(bitCount(planes_used[w]));
        for (int p = 0; p < max_planes && has_walls != 0u; ++p)
            if ((planes_used[p >> 5] & (1u << (p & 31))) != 0u && is_no_wall(plane_id[p])) status = STATUS_NEEDS_EXACT;
        if (vertices != 2u * faces - 4u) status = STATUS_NEEDS_EXACT;  // Euler, for a simple polytope
    }
    if (want_geometry != 0u && status == STATUS_CERTIFIED) {
        measure_cell();
        if (!is_measured(push.volume_tolerance)) status = STATUS_NEEDS_EXACT;
        geometry[4u * cell] = written(volume);
        geometry[4u * cell + 1u] = written(mass_center.x);
        geometry[4u * cell + 2u] = written(mass_center.y);
        geometry[4u * cell + 3u] = written(mass_center.z);
    }
#ifdef DECIDES_TIES
    if (status == STATUS_CERTIFIED && met_tie) keep_true_faces(faces, vertices);
#endif
    if (push.neighbors != 0u && status == STATUS_CERTIFIED) {
        for (int w = 0; w < plane_words; ++w)
            for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u) {
                const int plane = 32 * w + findLSB(rest);
                const int id = plane_id[plane];
                if (id < 0 && push.walls == 0u) continue;
                if (want_geometry == 2u) areas[length * push.row_stride + slot] = written(not_negative(area[plane]));
                rows[length * push.row_stride + slot] = id < 0 ? listed_wall(id) : int(seed_input[id]);
                ++length;
            }
    }
    if (loops_were_cut_short(2u + (push.cell_count >> 31))) {
        status = STATUS_CANDIDATES_EXHAUSTED;
        length = 0u;
    }
    const bool certified = status == STATUS_CERTIFIED;
    const uint known = (faces << INFO_FACES_SHIFT) | (vertices << INFO_VERTICES_SHIFT) | (exponent << INFO_EXPONENT_SHIFT);
    put_cell(cell, certified ? status | known : status, length, tier == 0u ? slot : slot | SECOND_TIER_BIT);
}

// Notes that the cell was tried, and its planes and corners where they describe it: without ties.
void note_for_next_frame(uint cell) {
    if (push.keeps == 0u) return;
    uint note = tier == 0u ? KEPT_TRIED : KEPT_TRIED | KEPT_TRIED_AGAIN, planes = 0u;
    bool is_simple = status == STATUS_CERTIFIED && vertex_count <= KEPT_CORNERS;
#ifdef DECIDES_TIES
    is_simple = is_simple && !met_tie;
#endif
    if (is_simple) {
        for (int w = 0; w < plane_words; ++w) planes += uint(bitCount(planes_used[w]));
        is_simple = planes <= KEPT_PLANES;
    }
    if (is_simple) {
        uint rank = 0u;
        for (int w = 0; w < plane_words; ++w)
            for (uint rest = planes_used[w]; rest != 0u; rest &= rest - 1u) {
                const int plane = 32 * w + findLSB(rest);
                horizon[plane] = rank;
                rows[plane_place(cell, rank)] = plane_id[plane];
                ++rank;
            }
        for (int v = 0; v < vertex_count; ++v) {
            const uint corner = vertex_planes[v];
            rows[corner_place(cell, uint(v))] = int(pack_planes(
                horizon[plane_of(corner, 0)], horizon[plane_of(corner, 1)], horizon[plane_of(corner, 2)]));
        }
        note |= KEPT_MADE | planes | (uint(vertex_count) << KEPT_CORNERS_SHIFT);
    }
    if (loops_were_cut_short(2u + (push.cell_count >> 31))) note &= KEPT_TRIED | KEPT_TRIED_AGAIN;
    of_cells[word_at(WORDS_KEPT, cell)] = note;
}

#endif
