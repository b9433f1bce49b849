// upload: writes the images of all seeds behind the seeds. Unused places get no coordinates. With too few places all
// stay empty, and no cell is certified.
//
// Variant: TRICLINIC, as in upload_wrap.comp.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "numbers/weights.glsl"
#include "shared/interface.h"
#include "shared/layout.h"
#ifdef TRICLINIC
#include "upload/lattice.glsl"
#else
#include "upload/images.glsl"
#endif

layout(std430, binding = BINDING_SCAN_DATA) readonly buffer Offsets { uint offsets[]; };
layout(std430, binding = BINDING_RUN_STATE) buffer State { RunState state; };
layout(std430, binding = BINDING_NAMES) writeonly buffer Names { uvec2 names[]; };
layout(std430, binding = BINDING_HEADER) buffer Header { FrameHeader header; };

#ifdef TRICLINIC
void put_image(uint place, uint seed, uint number) {
    uvec2 x = point_x(seed), y = point_y(seed), z = point_z(seed);
    ivec3 shift;
    count_images(x, y, z, number, shift);
    put_point(push.count + place, x, y, z);
    names[place] = uvec2(seed, uint((shift.x + 128) << 16 | (shift.y + 128) << 8 | (shift.z + 128)));
}
#else
uvec2 moved(uvec2 x, int by, int axis) {
    return by == 0 ? x : (by < 0 ? subtract64(x, push.side[axis]) : add64(x, push.side[axis]));
}
bool has_image(uvec2 x, int by, int axis) {
    return by == 0 || (by < 0 ? has_lower_image(x, axis) : has_upper_image(x, axis));
}

// Writes image `number` of a seed, in the order of shifts, to a place.
void put_image(uint place, uint seed, uint number) {
    const uvec2 x = point_x(seed), y = point_y(seed), z = point_z(seed);
    for (int code = 0; code < 27; ++code) {
        const int a = code / 9 - 1, b = code / 3 % 3 - 1, c = code % 3 - 1;
        const uint shift = uint((a + 128) << 16 | (b + 128) << 8 | (c + 128));
        if (shift == SHIFT_NONE || !has_image(x, a, 0) || !has_image(y, b, 1) || !has_image(z, c, 2)) continue;
        if (number-- != 0u) continue;
        put_point(push.count + place, moved(x, a, 0), moved(y, b, 1), moved(z, c, 2));
        names[place] = uvec2(seed, shift);
        return;
    }
}
#endif

void main() {
    const uint place = linear_invocation(), capacity = push.total - push.count;
    if (place >= capacity) return;
    const uint last = push.count - 1u;
    uint images = offsets[last] + images_of(point_x(last), point_y(last), point_z(last));
    if (place == 0u) header.images = images;
    if (images > capacity) {
        if (place == 0u) state.incomplete = 1u;
        images = 0u;
    }
    if (place < images) {
        // The last seed whose images do not begin behind this place.
        uint low = 0u, high = last;
        while (low < high) {
            const uint middle = (low + high + 1u) / 2u;
            if (offsets[middle] <= place)
                low = middle;
            else
                high = middle - 1u;
        }
        put_image(place, low, place - offsets[low]);
        if (weighted != 0u) put_weight(push.count + place, point_weight(low));
    } else {
        put_none(push.count + place);
    }
}
