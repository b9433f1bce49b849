// upload: converts coordinates to whole numbers of units. It rounds down and records whether any was rounded. On
// request, points that are outside of the box or not finite get NO_COORDINATE.
//
// Variant: WEIGHTS converts weights, one a point, in the same way. On request the point of a weight beyond the bounds
// gets no coordinates. Otherwise a weight below the lowest bound becomes 0: its point has no cell and cuts none.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "numbers/int64.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { UploadPush push; };
layout(std430, binding = BINDING_RAW) readonly buffer Raw { uint raw[]; };
layout(std430, binding = BINDING_RUN_STATE) buffer State { RunState state; };

#include "upload/points.glsl"

// Returns (-1)^negative mantissa 2^exponent in units.
uvec2 in_units(bool negative, uvec2 mantissa, int exponent, inout bool lost) {
    const uvec2 value = negative ? negate64(mantissa) : mantissa;
    return exponent >= 0 ? shift_left64(value, uint(exponent)) : shift_right64(value, uint(-exponent), lost);
}

// Returns a whole number that orders doubles as their values do; -0 counts as 0.
uvec2 ordered_bits(uvec2 bits) {
    if (bits == uvec2(0u, 0x80000000u)) bits = uvec2(0);
    return (bits.y & 0x80000000u) != 0u ? ~bits : uvec2(bits.x, bits.y | 0x80000000u);
}

// Returns the bits of the double that equals a finite float.
uvec2 widened(uint bits) {
    uint exponent = (bits >> 23) & 0xffu, mantissa = bits & 0x7fffffu;
    const uint sign = bits & 0x80000000u;
    if (exponent == 0u) {
        if (mantissa == 0u) return uvec2(0u, sign);
        const uint up = 23u - uint(findMSB(mantissa));
        mantissa = (mantissa << up) & 0x7fffffu;
        return uvec2(mantissa << 29, sign | ((897u - up) << 20) | (mantissa >> 3));
    }
    return uvec2(mantissa << 29, sign | ((exponent + 896u) << 20) | (mantissa >> 3));
}

uint place_of(uint point, uint axis) {
    return push.begin + push.stride * point + axis;
}

// Outputs the number's place in the order of doubles. Returns false when it is not finite.
bool find_order(uint point, uint axis, out uvec2 order) {
    const uint at = place_of(point, axis);
    uvec2 bits;
    if (push.format == POINTS_FLOAT32)
        bits = ((raw[at] >> 23) & 0xffu) == 0xffu ? uvec2(0u, 0x7ff00000u) : widened(raw[at]);
    else
        bits = uvec2(raw[2u * at], raw[2u * at + 1u]);
    order = ordered_bits(bits);
    return ((bits.y >> 20) & 0x7ffu) != 0x7ffu;
}

bool is_inside(uint point, uint axis) {
    uvec2 x;
    return find_order(point, axis, x) && !less64(x, push.lower[axis]) && !less64(push.upper[axis], x);
}

uvec2 coordinate(uint point, uint axis, inout bool lost) {
    const uint at = place_of(point, axis);
    uvec2 value;
    if (push.format == POINTS_UNITS) {
        value = uvec2(raw[2u * at], raw[2u * at + 1u]);
    } else if (push.format == POINTS_FLOAT32) {
        const uint bits = raw[at];
        const uint exponent = (bits >> 23) & 0xffu;
        const uint mantissa = (bits & 0x7fffffu) | (exponent > 0u ? 0x800000u : 0u);
        value = in_units((bits >> 31) != 0u, uvec2(mantissa, 0u), int(max(exponent, 1u)) - 150 + push.shift, lost);
    } else {
        const uvec2 bits = uvec2(raw[2u * at], raw[2u * at + 1u]);
        const uint exponent = (bits.y >> 20) & 0x7ffu;
        const uvec2 mantissa = uvec2(bits.x, (bits.y & 0xfffffu) | (exponent > 0u ? 0x100000u : 0u));
        value = in_units((bits.y >> 31) != 0u, mantissa, int(max(exponent, 1u)) - 1075 + push.shift, lost);
    }
    return subtract64(value, push.origin[axis]);
}

void main() {
    const uint point = linear_invocation();
    if (point >= push.count) return;
    const bool checks_box = (push.check & CHECK_BOX) != 0u;
    bool lost = false;
    if ((push.check & CHECK_COUNT) != 0u && point >= state.present) {
        put_none(push.first + point);
        return;
    }
#ifdef WEIGHTS
    const bool inside = is_inside(point, 0u);
    put_weight(push.first + point, inside ? coordinate(point, 0u, lost) : uvec2(0));
    if (!inside && checks_box) put_none(push.first + point);
    if (lost || !inside && !checks_box) atomicOr(state.lossy_weights, 1u);
#else
    if (checks_box && !(is_inside(point, 0u) && is_inside(point, 1u) && is_inside(point, 2u))) {
        put_none(push.first + point);
        return;
    }
    put_point(push.first + point, coordinate(point, 0u, lost), coordinate(point, 1u, lost), coordinate(point, 2u, lost));
    if (lost) atomicOr(state.lossy, LOSSY_POINTS);
#endif
}
