// Computes sums, products, conversions, quotients, roots and sums of products of given numbers. The host derives from
// them how the device rounds. Variant: FLOAT64.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { ScanPush push; };
#ifdef FLOAT64
#define real double
#else
#define real float
#endif
layout(std430, binding = BINDING_RAW) readonly buffer Operands { real operands[]; };
layout(std430, binding = BINDING_GEOMETRY) writeonly buffer Results { real results[]; };

void main() {
    const uint i = linear_invocation();
    if (i >= push.count) return;
    const real a = operands[2u * i], b = operands[2u * i + 1u];
    precise const real sum = a + b, product = a * b;
    precise const real quotient = a / b, side = sqrt(abs(a)), both = fma(a, b, b);
    results[6u * i] = sum;
    results[6u * i + 1u] = product;
    results[6u * i + 2u] = real(0x01000001u + 2u * i);
    results[6u * i + 3u] = quotient;
    results[6u * i + 4u] = side;
    results[6u * i + 5u] = both;
}
