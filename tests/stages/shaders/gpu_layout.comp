// For tests/stages/gpu/gpu_layout.cpp: writes each field of a struct of shaders/shared/layout.h, by name, to a word.
// The variants are named like the structs.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/layout.h"

layout(local_size_x_id = 0) in;
layout(std430, binding = 1) writeonly buffer Words { uint words[]; };

#if defined(STATE)
layout(push_constant) uniform Push { uint unused; };
layout(std430, binding = 0) readonly buffer Source { STATE state; };
#else
layout(push_constant) uniform Push { PUSH push; };
layout(std430, binding = 0) readonly buffer Source { uint unused[]; };
#endif

uint written = 0u;

void put(uint value) {
    words[1u + written++] = value;
}
void put(int value) {
    put(uint(value));
}
void put(float value) {
    put(floatBitsToUint(value));
}
void put(uvec2 value) {
    put(value.x);
    put(value.y);
}
void put(uvec2 values[3]) {
    for (int i = 0; i < 3; ++i) put(values[i]);
}

void main() {
    if (gl_GlobalInvocationID.x != 0u) return;
#if defined(UPLOAD)
    put(push.origin);
    put(push.first);
    put(push.count);
    put(push.shift);
    put(push.format);
    put(push.lower);
    put(push.upper);
    put(push.stride);
    put(push.check);
    put(push.begin);
    put(push.total);
#elif defined(IMAGES)
    put(push.lower);
    put(push.side);
    put(push.extent);
    put(push.periodic);
    put(push.count);
    put(push.total);
#elif defined(SORT)
    put(push.count);
    put(push.tiles);
    put(push.shift);
    put(push.high_word);
#elif defined(KEY)
    put(push.total);
    put(push.bits);
    put(push.blocks_per_unit);
#elif defined(SCAN)
    put(push.count);
#elif defined(BOXES)
    put(push.seed_count);
    put(push.level);
    put(push.first);
    put(push.count);
    put(push.below_first);
    put(push.below_count);
#elif defined(REACH)
    put(push.lower);
    put(push.upper);
    put(push.side);
    put(push.bounded);
    put(push.periodic);
    put(push.seed_count);
    put(push.own_count);
    put(push.level_count);
    put(push.node_count);
    put(push.max_visits);
#elif defined(KNN)
    put(push.lower);
    put(push.upper);
    put(push.bounded);
    put(push.first_cell);
    put(push.cell_count);
    put(push.seed_count);
    put(push.own_count);
    put(push.level_count);
    put(push.max_visits);
    put(push.keeps);
    for (int i = 0; i < MAX_LEVELS; ++i) put(push.level_first[i]);
#elif defined(CLIP)
    put(push.extent);
    put(push.first_cell);
    put(push.cell_count);
    put(push.seed_count);
    put(push.own_count);
    put(push.row_stride);
    put(push.walls);
    put(push.neighbors);
    put(push.volume_tolerance);
    put(push.max_visits);
    put(push.bounded);
    put(push.keeps);
    put(push.kept_reach);
    put(push.level_count);
    for (int i = 0; i < MAX_LEVELS; ++i) put(push.level_first[i]);
#elif defined(CELLS)
    put(push.extent);
    put(push.lower);
    put(push.upper);
    put(push.bounded);
    put(push.first_cell);
    put(push.cell_count);
    put(push.seed_count);
    put(push.own_count);
    put(push.level_count);
    put(push.max_visits);
    put(push.row_stride);
    put(push.walls);
    put(push.neighbors);
    put(push.volume_tolerance);
    put(push.keeps);
#elif defined(KEPT)
    put(push.cell_count);
    put(push.own_count);
    put(push.image_count);
    put(push.keeps);
    put(push.capacity);
    put(push.max_pending);
#elif defined(COVER)
    put(push.extent);
    for (int i = 0; i < 9; ++i) put(push.vectors[i]);
    put(push.periodic);
    put(push.bounded);
    put(push.cell_count);
    put(push.seed_count);
    put(push.own_count);
    put(push.keeps);
    put(push.root);
#elif defined(TODO)
    put(push.cell_count);
    put(push.max_of_tile);
    put(push.group);
    put(push.places);
    put(push.keeps);
#elif defined(ROWS)
    put(push.first_cell);
    put(push.cell_count);
    put(push.row_stride);
    put(push.second_row_stride);
    put(push.second_first);
    put(push.capacity);
    put(push.window);
    put(push.window_bits);
    put(push.named_from);
    put(push.shifts);
    put(push.shift);
#elif defined(GATHER)
    put(push.first_cell);
    put(push.cell_count);
    put(push.first_entry);
    put(push.entry_count);
    put(push.areas);
    put(push.shifts);
#elif defined(FRAME)
    put(push.first_cell);
    put(push.cell_count);
    put(push.capacity);
    put(push.neighbors);
    put(push.geometry);
    put(push.shift);
    put(push.seed_count);
    put(push.own_count);
    put(push.keeps);
#elif defined(RUN)
    put(state.lossy);
    put(state.suspects);
    put(state.duplicates);
    put(state.incomplete);
    put(state.weight_exponent);
    put(state.lossy_weights);
    put(state.heaviest);
    put(state.present);
    put(state.unused);
#elif defined(CHUNK)
    put(state.todo_count);
    put(state.groups_x);
    put(state.groups_y);
    put(state.groups_z);
    put(state.subgroups_x);
    put(state.subgroups_y);
    put(state.subgroups_z);
    put(state.left_count);
    put(state.row_base);
    put(state.kept_pending);
    put(state.kept_over);
    put(state.kept_over_cell);
    put(state.kept_failed);
    put(state.unknown_count);
    put(state.kept_point);
    for (int i = 0; i < KEPT_UNKNOWN; ++i) put(state.unknown[i]);
    for (int i = 0; i < state.unused.length(); ++i) put(state.unused[i]);
#elif defined(HEADER)
    put(state.seeds);
    put(state.certified);
    put(state.unresolved);
    put(state.duplicates);
    put(state.outside);
    put(state.entries);
    put(state.faces);
    put(state.images);
    put(state.empty);
    put(state.kept);
#elif defined(CELL)
    put(state.status);
    put(state.row_begin);
    put(state.row_length);
    put(state.faces);
#elif defined(WALL)
    for (int k = 0; k < 3; ++k) put(state.normal[k]);
    for (int k = 0; k < 2; ++k) put(state.offset[k]);
    for (int k = 0; k < 4; ++k) put(state.rough[k]);
#endif
    words[0] = written;
}
