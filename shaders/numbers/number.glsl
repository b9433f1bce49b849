// The numbers that measure a cell: float64, or sums of two float32.
//
// Sums and products of sums are those of Dekker (1971) and Knuth. Factors of a product are split by rounding their
// bits, which is exact on every device. Where a device rounds to nearest, they are right to 2^-44, reciprocals and
// roots to 2^-42. Rounding to the other neighbor costs less than two bits (Boldo, Graillat, Muller 2017).
//
// Variant: GEOMETRY_FLOAT64.
#ifndef VOTESS_NUMBERS_NUMBER_GLSL
#define VOTESS_NUMBERS_NUMBER_GLSL

#ifdef GEOMETRY_FLOAT64

#define Number double
const float number_unit = 1.1102230246251565e-16;  // unit roundoff
const float farthest_of_range = 3.0e38;            // it holds for cells with a smaller squared radius

Number number(float a) {
    return Number(a);
}
float rounded(Number a) {
    return float(a);
}
// Converts a whole number below 2^64.
Number number64(uvec2 m) {
    return Number(m.y) * 4294967296.0LF + Number(m.x);
}
Number times_power(Number a, float power_of_two) {
    return a * Number(power_of_two);
}
Number plus(Number a, Number b) {
    return a + b;
}
Number minus(Number a, Number b) {
    return a - b;
}
Number times(Number a, Number b) {
    return a * b;
}
Number reciprocal(Number a) {
    return 1.0LF / a;
}
Number root(Number a) {
    return sqrt(a);
}
uvec2 words_of(Number a) {
    return unpackDouble2x32(a);
}
Number of_words(uvec2 words) {
    return packDouble2x32(words);
}

#else

struct Number {
    float high, low;
};
const float number_unit = 9.094947e-13;  // 2^-40
const float farthest_of_range = 1.0e12;  // beyond, low parts of reciprocals may be flushed to zero

Number number(float a) {
    return Number(a, 0.0);
}
float rounded(Number a) {
    return a.high;
}

// Returns a + b where |a| >= |b|.
Number ordered_sum(float a, float b) {
    precise const float sum = a + b;
    precise const float rest = b - (sum - a);
    return Number(sum, rest);
}
Number exact_sum(float a, float b) {
    precise const float sum = a + b;
    precise const float of_b = sum - a;
    precise const float rest = (a - (sum - of_b)) + (b - of_b);
    return Number(sum, rest);
}
// Returns the leading 12 bits, so that products of two are exact; the rest of a has at most 12.
float leading_half(float a) {
    return uintBitsToFloat((floatBitsToUint(a) + 0x800u) & 0xfffff000u);
}
Number exact_product(float a, float b) {
    const float a1 = leading_half(a), b1 = leading_half(b);
    precise const float a2 = a - a1, b2 = b - b1, product = a * b;
    precise const float rest = a2 * b2 - (((product - a1 * b1) - a2 * b1) - a1 * b2);
    return Number(product, rest);
}

Number plus(Number a, Number b) {
    const Number sum = exact_sum(a.high, b.high);
    precise const float low = sum.low + (a.low + b.low);
    return ordered_sum(sum.high, low);
}
Number minus(Number a, Number b) {
    return plus(a, Number(-b.high, -b.low));
}
// Adds a float32 to a sum of many, which is rounded less well where most of it cancels.
Number plus(Number sum, float a) {
    const Number both = exact_sum(sum.high, a);
    return Number(both.high, sum.low + both.low);
}
Number times(Number a, Number b) {
    const Number product = exact_product(a.high, b.high);
    precise const float low = product.low + (a.high * b.low + a.low * b.high);
    return ordered_sum(product.high, low);
}
// Takes 24 bits from the leading one on, and the 24 behind these; below 2^32 the leading one is not found, and those hold
// the rest.
Number number64(uvec2 m) {
    const uint shift = uint(31 - findMSB(m.y | 1u)), high = (m.y << shift) | ((m.x >> 1) >> (31u - shift)),
               low = m.x << shift;
    const float power = uintBitsToFloat((127u + 40u - shift) << 23);  // 2^(40 - shift)
    return ordered_sum(float(high >> 8) * power,
                       float((high & 0xffu) << 16 | low >> 16) * (power * 5.9604644775390625e-8));
}
Number times_power(Number a, float power_of_two) {
    return Number(a.high * power_of_two, a.low * power_of_two);
}
// One step of Newton's method improves the float32 result, as in root().
Number reciprocal(Number a) {
    const float first = 1.0 / a.high;
    const Number rest = minus(number(1.0), times(a, number(first)));
    return ordered_sum(first, rest.high * first);
}
Number root(Number a) {
    if (!(a.high > 0.0)) return number(0.0);
    const float first = sqrt(a.high);
    const Number rest = minus(a, exact_product(first, first));
    return ordered_sum(first, 0.5 * rest.high / first);
}
uvec2 words_of(Number a) {
    return uvec2(floatBitsToUint(a.high), floatBitsToUint(a.low));
}
Number of_words(uvec2 words) {
    return Number(uintBitsToFloat(words.x), uintBitsToFloat(words.y));
}

#endif

struct Vector {
    Number x, y, z;
};

Vector plus(Vector a, Vector b) {
    return Vector(plus(a.x, b.x), plus(a.y, b.y), plus(a.z, b.z));
}
Vector times(Vector a, Number b) {
    return Vector(times(a.x, b), times(a.y, b), times(a.z, b));
}
Number dot(Vector a, Vector b) {
    return plus(plus(times(a.x, b.x), times(a.y, b.y)), times(a.z, b.z));
}
Vector cross(Vector a, Vector b) {
    return Vector(minus(times(a.y, b.z), times(a.z, b.y)), minus(times(a.z, b.x), times(a.x, b.z)),
                  minus(times(a.x, b.y), times(a.y, b.x)));
}
Vector vector(vec3 a) {
    return Vector(number(a.x), number(a.y), number(a.z));
}
vec3 rounded(Vector a) {
    return vec3(rounded(a.x), rounded(a.y), rounded(a.z));
}
#ifndef GEOMETRY_FLOAT64
Vector plus(Vector a, vec3 b) {
    return Vector(plus(a.x, b.x), plus(a.y, b.y), plus(a.z, b.z));
}
// Returns h - n.x, right to 2^-40 (|h| + |n||x|) and one rounding where the device rounds to nearest. Products and
// differences of high parts are exact; the rest is small.
float residual(Vector n, Number h, vec3 x) {
    const Number px = exact_product(n.x.high, x.x), py = exact_product(n.y.high, x.y), pz = exact_product(n.z.high, x.z);
    const Number a = exact_sum(h.high, -px.high), b = exact_sum(a.high, -py.high), c = exact_sum(b.high, -pz.high);
    precise const float of_products = (px.low + n.x.low * x.x) + (py.low + n.y.low * x.y) + (pz.low + n.z.low * x.z);
    precise const float rest = ((a.low + b.low) + (c.low + h.low)) - of_products;
    return c.high + rest;
}
#endif

#endif
