// The loops of SurfaceKernels. Included once for each instruction set, inside of a namespace with its Real, `width`
// numbers in a register, bits_at_most() and root().

using solid::tiny;
using solid::unit;

VOTESS_INLINE Real load(const double* from) {
    Real r;
    std::memcpy(&r, from, sizeof r);
    return r;
}
VOTESS_INLINE void store(double* to, const Real& r) {
    std::memcpy(to, &r, sizeof r);
}
VOTESS_INLINE Real larger(const Real& a, const Real& b) {
    return a > b ? a : b;
}
VOTESS_INLINE Real size_of(const Real& r) {
    return larger(r, -r);
}

// Returns the square of the distance between boxes.
VOTESS_INLINE Real square_between(const Real* lower, const Real* upper, const Box& home) {
    Real square{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Real gap = larger(larger(lower[k] - home.upper[k], home.lower[k] - upper[k]), Real{});
        square += gap * gap;
    }
    return square;
}

unsigned near_boxes(const cpu::BoxBlock& boxes, const Box& home, double reach, double* squares) {
    unsigned near = 0;
    for (std::size_t j = 0; j < group; j += width) {
        Real lower[3], upper[3];
        for (std::size_t k = 0; k < 3; ++k) lower[k] = load(boxes.lower[k] + j), upper[k] = load(boxes.upper[k] + j);
        const Real square = square_between(lower, upper, home);
        store(squares + j, square);
        near |= bits_at_most(square, Real{} + reach) << j;
    }
    return near;
}

unsigned near_seeds(const double* const* places, const TriangleFrame& frame, double reach, SeedFunctions& out) {
    // Bounds on the errors of a value in units of its terms, rounded up.
    constexpr double function_rounding = 8 * unit;
    unsigned near = 0;
    for (std::size_t j = 0; j < group; j += width) {
        const Real x[3] = {load(places[0] + j), load(places[1] + j), load(places[2] + j)};
        const Real square = square_between(x, x, frame.box);
        store(out.square + j, square);
        near |= bits_at_most(square, Real{} + reach) << j;
    }
    if (near == 0) return 0;
    for (std::size_t j = 0; j < group; j += width) {
        const Real x = load(places[0] + j) - frame.center[0], y = load(places[1] + j) - frame.center[1],
                   z = load(places[2] + j) - frame.center[2];
        const auto along = [&](const Vector3& way) { return x * way[0] + y * way[1] + z * way[2]; };
        const Real square = x * x + y * y + z * z;
        const Real du = -2 * along(frame.way[0]), dv = -2 * along(frame.way[1]);
        store(out.f + j, square - 2 * along(frame.first));
        store(out.du + j, du);
        store(out.dv + j, dv);
        store(out.error + j, function_rounding * (square + 2 * root(square) * frame.length) + tiny);
        store(out.change + j, size_of(du) + size_of(dv));
    }
    return near;
}

std::size_t next_cutting(const SeedFunctions& seeds, unsigned& pending, const Envelope& e, std::uint8_t* removed,
                         bool& is_sure) {
    while (pending != 0) {
        const auto k = static_cast<std::size_t>(__builtin_ctz(pending));
        pending &= pending - 1;
        if (seeds.square[k] > e.reach) continue;
        const double f = seeds.f[k], du = seeds.du[k], dv = seeds.dv[k];
        // Of the difference of values, at a corner without error; and its change by an error of both weights.
        const double slack = Envelope::value_errors * (seeds.error[k] + e.max_value_error);
        const double change = 1.01 * (seeds.change[k] + e.max_change);
        unsigned any = 0, unsure = 0;
        for (std::size_t c = 0; c < e.count; c += group) {
            unsigned nearer = 0, maybe = 0;
            for (std::size_t j = c; j < c + group; j += width) {
                const Real difference = (f + (load(e.u + j) * du + load(e.v + j) * dv)) - load(e.value + j);
                const Real bound = slack + load(e.error + j) * change;
                nearer |= bits_below(difference, -bound) << (j - c);
                maybe |= bits_at_most(difference, bound) << (j - c);
            }
            removed[c / group] = static_cast<std::uint8_t>(nearer);
            any |= maybe;
            unsure |= maybe ^ nearer;
        }
        is_sure = unsure == 0;
        if (any != 0) return k;
    }
    return group;
}

// Where two functions are 0, u and v are quotients of determinants.
void place_corners(Ring& ring, const TriangleFrame& frame, double f, double du, double dv) {
    for (std::size_t k = 0; k < ring.count; k += width) {
        const Real g = load(ring.g + k), gu = load(ring.gu + k), gv = load(ring.gv + k);
        const Real h = load(ring.g + k + 1), hu = load(ring.gu + k + 1), hv = load(ring.gv + k + 1);
        const Real g_size = load(ring.size + k), h_size = load(ring.size + k + 1);
        const Real g_error = load(ring.error + k), h_error = load(ring.error + k + 1);
        const Real error = 2 * (g_size * h_error + h_size * g_error + g_error * h_error) + (4 * unit) * g_size * h_size;
        const Real across = gu * hv - gv * hu, inverse = 1 / across, sure = size_of(across) - error;
        const Real bound = 2.1 * error / sure + 8 * unit;
        const auto is_good = (sure > 0.0) & (bound < 1.0);
        const Real u = is_good ? (gv * h - g * hv) * inverse : Real{} + 1.0 / 3;
        const Real v = is_good ? (g * hu - gu * h) * inverse : Real{} + 1.0 / 3;
        const Real corner_error = is_good ? bound : Real{} + 1.0;
        const auto place = [&](std::size_t i) { return frame.first[i] + (u * frame.way[0][i] + v * frame.way[1][i]); };
        const Real x = place(0), y = place(1), z = place(2), value = f + (u * du + v * dv);
        store(ring.u + k, u);
        store(ring.v + k, v);
        store(ring.value + k, value);
        store(ring.square + k, value + (x * x + y * y + z * z));
        store(ring.corner_error + k, corner_error);
    }
}

double largest_square(const Envelope& e) {
    Real largest{};
    for (std::size_t c = 0; c < e.count; c += width) largest = larger(load(e.square + c), largest);
    double square = largest[0];
    for (std::size_t j = 1; j < width; ++j) square = largest[j] > square ? largest[j] : square;
    return square;
}

constexpr SurfaceKernels all{near_boxes, near_seeds, next_cutting, place_corners, largest_square};
