// kept: decides whether the kept cells are cells of the diagram, and drops all of them if not.
//
// Kept cells are convex, and share whole faces with kept and made ones. So all places of the domain have the same number
// of cells over them, if no unknown cell has a face with a kept one. That is so unless some kept cell is over the seed of an unknown
// one (engine/gpu/README.md). The number is 1 at the place of a seed where one kept cell may be, and no other cell has
// less power.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { CoverPush push; };
layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
layout(std430, binding = BINDING_RUN_STATE) readonly buffer State { RunState state; };

#include "kept/kept_word.glsl"
#include "search/seeds.glsl"
#include "shared/chunk.glsl"

// Returns the least squared distance of the images of a seed from the place.
float squared_distance(uint seed) {
    const uint at = chunk.kept_point;
    const vec3 way = vec3(rough_difference(seed_x(seed), seed_x(at)), rough_difference(seed_y(seed), seed_y(at)),
                          rough_difference(seed_z(seed), seed_z(at)));
    const ivec3 steps = ivec3(push.periodic & 1u, (push.periodic >> 1) & 1u, (push.periodic >> 2) & 1u);
    float least = dot(way, way);
    for (int a = -steps.x; a <= steps.x; ++a)
        for (int b = -steps.y; b <= steps.y; ++b)
            for (int c = -steps.z; c <= steps.z; ++c) {
                vec3 to = way;
                for (int k = 0; k < 3; ++k)
                    to[k] += float(a) * push.vectors[k] + float(b) * push.vectors[3 + k] + float(c) * push.vectors[6 + k];
                least = min(least, dot(to, to));
            }
    return least;
}

// Returns whether the seed certainly has more power at the place than the cell over it.
bool has_more_power(uint seed) {
    const uint over = chunk.kept_over_cell;
    const float far = squared_distance(seed), near = squared_distance(over);
    float lighter = 0.0;
    if (weighted != 0u)
        lighter = rough_difference(seed_weight(over), seed_weight(seed)) *
                  uintBitsToFloat(uint(127 + state.weight_exponent) << 23);
    return far - near + lighter > 1e-4 * (far + near + abs(lighter));
}

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count) return;
    if (cell == 0u && (chunk.kept_pending != 0u || chunk.kept_over > 1u || chunk.unknown_count > KEPT_UNKNOWN ||
                       (weighted != 0u && chunk.unknown_count != 0u)))
        chunk.kept_failed = 1u;
    if (chunk.kept_over != 1u || seed_input[cell] >= push.own_count || seed_x(cell).y == NO_COORDINATE) return;
    if ((word_of(WORDS_KEPT, cell) & KEPT_HELD) == 0u && !has_more_power(cell)) chunk.kept_failed = 1u;
}
