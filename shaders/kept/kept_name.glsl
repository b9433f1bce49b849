// The neighbors of a cell by names that do not change from frame to frame. The .comp declares `push`, with own_count, before.
//
// Variant: NAMES, where there are images.
#ifndef VOTESS_KEPT_KEPT_NAME_GLSL
#define VOTESS_KEPT_KEPT_NAME_GLSL

#include "shared/interface.h"

layout(std430, binding = BINDING_SEED_INPUT) readonly buffer SeedInput { uint seed_input[]; };
#ifdef NAMES
layout(std430, binding = BINDING_NAMES) readonly buffer NameList { uvec2 names[]; };
#endif

// A point or a wall, and the shift of its image. Shifts are three bytes in two's complement.
struct Name {
    int id;
    uint shift;
};

// plane: sorted seed or wall.
Name name_of(int plane) {
    if (plane < 0) return Name(plane, 0u);
    const uint point = seed_input[plane] & INDEX_MASK;
#ifdef NAMES
    if (point >= push.own_count) {
        const uvec2 name = names[point - push.own_count];
        return Name(int(name.x), name.y ^ SHIFT_NONE);
    }
#endif
    return Name(int(point), 0u);
}

// Returns the name as seen from an image with this shift.
Name seen_from(Name name, uint shift) {
    if (name.id < 0) return name;
    uint difference = 0u;
    for (uint mask = 0xffu; mask <= 0xff0000u; mask <<= 8) difference |= ((name.shift & mask) - (shift & mask)) & mask;
    return Name(name.id, difference);
}

#endif
