// The decisions of a device (shaders/clip/filter.glsl) against exact signs of near-ties: a vertex of three bisectors,
// and a seed nearly on the sphere through the cell's own seed and those three.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <array>
#include <bit>
#include <cmath>

#include "shared/config.h"
#include "shared/interface.h"
#include "support/check.hpp"
#include "support/gpu/vulkan.hpp"
#include "support/random.hpp"

using namespace votess::gpu::vulkan;

namespace {

using Wide = __int128;
using Offset = std::array<Wide, 3>;  // from the cell's seed, in sixteenths of a unit

constexpr std::size_t words_each = 23;  // of a case, see the shader
constexpr int fractions_each = 16;
constexpr Wide fractions = fractions_each;
struct CountPush {
    std::uint32_t count;
};

enum Bits : std::uint32_t { vertex = 1, outside = 2, inside = 4, pruned = 0xf8 };

struct Case {
    std::array<Offset, 4> seed;  // those of the vertex, in positive orientation in float64, and the last one
    int exponent = 0;            // of the unit of length
    bool lossy = false;
    std::array<Wide, 3> origin;  // the cell's seed, in sixteenths too; whole units where nothing is lossy
    double distance = 0;         // about, of the last seed to the sphere, over its radius
    // In a power diagram: by how much the seeds are heavier, in sixteenths of a unit, 2^weight_exponent squared units.
    std::array<Wide, 4> heavier{};
    int weight_exponent = 0;
    std::array<std::int32_t, 3> tilt{};  // in 2^TILT_BITS units
};

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector unit(const Vector& a) {
    const double length = std::sqrt(dot(a, a));
    return {a[0] / length, a[1] / length, a[2] / length};
}

Vector random_vector(test::Random& random) {
    return {random.gaussian(), random.gaussian(), random.gaussian()};
}

double log_uniform(test::Random& random, double lower, double upper) {
    return std::exp2(random.uniform(std::log2(lower), std::log2(upper)));
}

// Returns the determinant of the vertex's planes on the device.
double orientation(const Case& c) {
    std::array<Vector, 3> n;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            n[i][k] = static_cast<double>((c.origin[k] + c.seed[i][k]) / fractions - c.origin[k] / fractions);
    return n[0][0] * (n[1][1] * n[2][2] - n[1][2] * n[2][1]) - n[0][1] * (n[1][0] * n[2][2] - n[1][2] * n[2][0]) +
           n[0][2] * (n[1][0] * n[2][1] - n[1][1] * n[2][0]);
}

struct Family {
    bool float64 = false, lossy = false;
    // Half of the vertices have three planes nearly through one line. This is about one over their condition.
    double narrowest = 1e-3, widest = 1;
    int max_exponent = 57;
    bool weights = false, tilts = false;
};

// Sets a tilt, and adds its share to the weights. So the vertex is where it was, relative to the center.
void add_tilt(Case& c, test::Random& random, double radius) {
    const Vector direction = unit(random_vector(random));
    const double length = std::min(radius * log_uniform(random, 0.1, 8), std::ldexp(0.9, MAX_TILT_BITS));
    for (std::size_t k = 0; k < 3; ++k)
        c.tilt[k] = static_cast<std::int32_t>(std::ldexp(length * direction[k], -TILT_BITS));
    for (std::size_t i = 0; i < 4; ++i) {
        Wide along = 0;
        for (std::size_t k = 0; k < 3; ++k) along += (Wide{c.tilt[k]} << (TILT_BITS + 1)) * c.seed[i][k];
        along >>= c.weight_exponent;
        c.heavier[i] += c.lossy ? along : along / fractions * fractions;
    }
}

Case random_case(test::Random& random, const Family& family) {
    Case c;
    c.lossy = family.lossy;
    c.exponent = static_cast<int>(random.integer(SMALLEST_CELL_EXPONENT, family.max_exponent));
    const double length = std::ldexp(1.0, c.exponent);
    const double most = std::ldexp(0.4, COORDINATE_BITS - 1 - c.exponent);  // the room in the box
    const double radius = length * (random.chance(0.7) ? random.uniform(0.8, 3) : log_uniform(random, 0.8, most));
    const Vector to_center = unit(random_vector(random));
    const double narrow = random.chance(0.5) ? 1 : log_uniform(random, family.narrowest, family.widest);
    // Seeds nearly in one plane with the cell's own, with this normal; or near each other.
    Vector normal = unit(random_vector(random));
    while (std::abs(dot(to_center, normal)) > 0.6) normal = unit(random_vector(random));
    const bool through_line = random.chance(0.7);
    Vector base = random_vector(random);
    const auto near_line = [&](const Vector& any) {
        const double height = narrow * any[0] - dot(to_center, normal);
        Vector along = random_vector(random);
        const double off = dot(along, normal);
        for (std::size_t k = 0; k < 3; ++k) along[k] -= off * normal[k];
        along = unit(along);
        for (std::size_t k = 0; k < 3; ++k)
            along[k] = height * normal[k] + std::sqrt(std::max(1 - height * height, 0.0)) * along[k];
        return along;
    };
    // Relative to the sphere's center. None may be nearer to the cell's own seed than the unit of length.
    const auto place = [&](bool last, double size) {
        for (;;) {
            const Vector any = random_vector(random);
            Vector u = any;
            if (last) {
                if (random.chance(0.3))  // opposite to the own seed
                    for (std::size_t k = 0; k < 3; ++k) u[k] = to_center[k] + 1e-3 * any[k];
            } else if (narrow < 1) {
                if (through_line)
                    u = near_line(any);
                else
                    for (std::size_t k = 0; k < 3; ++k) u[k] = base[k] + std::sqrt(narrow) * any[k];
            }
            u = unit(u);
            Vector from_seed;
            for (std::size_t k = 0; k < 3; ++k) from_seed[k] = radius * to_center[k] + size * u[k];
            if (dot(from_seed, from_seed) > length * length) return u;
            base = random_vector(random);
        }
    };
    const auto rounded = [&](double x) {
        const Wide sixteenths = static_cast<Wide>(x * 16);  // differences of 2^62 units lose digits, which is harmless
        return c.lossy ? sixteenths + static_cast<Wide>(random.below(16)) : sixteenths / fractions * fractions;
    };
    // Mostly about as far as the uncertain range.
    const double unsure = std::max(family.float64 ? 0x1p-53 : 0x1p-24, c.lossy ? 1 / length : 0) / narrow;
    c.distance =
        random.chance(0.3) ? log_uniform(random, 1e-19, 1e-2) : std::min(unsure * log_uniform(random, 0.1, 1000), 0.1);
    c.weight_exponent = family.weights ? std::max(2 * std::ilogb(radius) + 8 - 56, 0) : 0;
    for (std::size_t i = 0; i < 4; ++i) {
        // The sphere on which seeds of this weight have the same power.
        double size = radius;
        if (family.weights && random.chance(0.8)) do {
                size = radius * log_uniform(random, 0.05, 8);
            } while (size < 0.8 * length && radius - size < 1.05 * length);
        const Vector u = place(i == 3, size);
        const double at = i < 3 ? size : size * (1 + (random.chance(0.5) ? c.distance : -c.distance));
        if (size != radius) c.heavier[i] = rounded(std::ldexp((size - radius) * (size + radius), -c.weight_exponent));
        for (std::size_t k = 0; k < 3; ++k) c.seed[i][k] = rounded(radius * to_center[k]) + rounded(at * u[k]);
    }
    for (auto& x : c.origin) {
        x = (Wide{1} << (COORDINATE_BITS + 3)) + static_cast<Wide>(random.below(std::uint64_t{1} << 40)) * fractions;
        if (c.lossy) x += static_cast<Wide>(random.below(16));
    }
    if (family.tilts) add_tilt(c, random, radius);
    if (orientation(c) < 0) {
        std::swap(c.seed[0], c.seed[1]);
        std::swap(c.heavier[0], c.heavier[1]);
    }
    return c;
}

// Whole units, rounded down, as on the device.
std::array<std::uint64_t, words_each> words(const Case& c) {
    std::array<std::uint64_t, words_each> all{};
    for (std::size_t k = 0; k < 3; ++k) {
        all[k] = static_cast<std::uint64_t>(c.origin[k] / fractions);
        for (std::size_t i = 0; i < 4; ++i)
            all[3 + 3 * i + k] = static_cast<std::uint64_t>((c.origin[k] + c.seed[i][k]) / fractions);
    }
    all[15] = static_cast<std::uint64_t>(c.exponent) | std::uint64_t{c.lossy} << 32 |
              static_cast<std::uint64_t>(c.weight_exponent) << 33;
    constexpr Wide own_weight = (Wide{1} << 60) * fractions + 7;  // rounded down too, by other sixteenths
    all[16] = static_cast<std::uint64_t>(own_weight / fractions);
    for (std::size_t i = 0; i < 4; ++i)
        all[17 + i] = static_cast<std::uint64_t>((own_weight - (c.lossy ? 0 : 7) + c.heavier[i]) / fractions);
    const auto word = [&](std::size_t k) { return std::uint64_t{static_cast<std::uint32_t>(c.tilt[k])}; };
    all[21] = word(0) | word(1) << 32;
    all[22] = word(2);
    return all;
}

mpz_class whole(Wide x) {
    const bool negative = x < 0;
    const auto m = static_cast<unsigned __int128>(negative ? -x : x);
    mpz_class result = static_cast<unsigned long>(m >> 64);
    result = (result << 64) + static_cast<unsigned long>(m);
    return negative ? mpz_class(-result) : result;
}

mpz_class determinant(const mpz_class* a, const mpz_class* b, const mpz_class* c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

struct Signs {
    int orientation;  // of the three planes of the vertex
    int side;         // of the vertex; +1 when the last seed cuts it off
};

// The bisectors are n.x = n.n / 2, less half of what the seed is heavier; expanding the determinant of four rows (n,
// n.n) by its last column.
Signs exact_signs(const Case& c) {
    mpz_class n[4][3], square[4];
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            n[i][k] = whole(c.seed[i][k]);
            square[i] += n[i][k] * n[i][k];
        }
    for (std::size_t i = 0; i < 4; ++i) square[i] -= (whole(c.heavier[i]) * fractions_each) << c.weight_exponent;
    const mpz_class det = determinant(n[0], n[1], n[2]);
    const mpz_class side = square[0] * determinant(n[1], n[2], n[3]) - square[1] * determinant(n[0], n[2], n[3]) +
                           square[2] * determinant(n[0], n[1], n[3]) - square[3] * det;
    return {sgn(det), sgn(side) * sgn(det)};
}

std::vector<std::uint32_t> verdicts_on(test::Gpu& gpu, const std::vector<Case>& cases, const Family& family) {
    const auto count = static_cast<std::uint32_t>(cases.size());
    Memory memory(*gpu.device, 1 << 20);
    PassInfo info;
    info.name = "test_filter";
    info.spirv = family.float64 ? votess::gpu::shaders::test_filter_f64 : votess::gpu::shaders::test_filter_f32;
    info.push_bytes = sizeof(CountPush);
    info.local_size = 64;
    info.constants = {
        {CONSTANT_UNIT_ROUNDOFF, std::bit_cast<std::uint32_t>(gpu.device->rounds_to_nearest() ? 0x1p-24f : 0x1p-23f)},
        {CONSTANT_WEIGHTS, family.weights ? 1u : 0u}};
    const Pass pass(*gpu.device, info);
    const Buffer in = memory.buffer(count * words_each * 8, MemoryKind::upload, "cases");
    const Buffer out = memory.buffer(count * 4, MemoryKind::download, "verdicts");
    auto at = in.as<std::uint64_t>().begin();
    for (const Case& c : cases) at = std::ranges::copy(words(c), at).out;
    in.flush();
    const BufferBinding bindings[] = {{2, &in}, {5, &out}};
    gpu.run(pass, bindings, push_bytes(CountPush{count}), count);
    out.invalidate();
    const auto found = out.as<std::uint32_t>();
    return {found.begin(), found.end()};
}

struct Counts {
    std::size_t vertices = 0, decided = 0, pruned = 0;
    std::size_t wrong = 0;
    std::string first;  // wrong one
};

// No decision of the device may contradict the exact signs.
Counts judge(test::Gpu& gpu, const Family& family, std::uint64_t seed) {
    const std::size_t all = test::by_size(100000, 4000), batch = 20000;
    test::Random random(seed);
    Counts counts;
    for (std::size_t done = 0; done < all; done += batch) {
        std::vector<Case> cases(std::min(batch, all));
        for (Case& c : cases) c = random_case(random, family);
        const auto verdicts = verdicts_on(gpu, cases, family);
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const std::uint32_t verdict = verdicts[i];
            if ((verdict & vertex) == 0) continue;
            ++counts.vertices;
            counts.decided += (verdict & (outside | inside)) != 0;
            counts.pruned += (verdict & pruned) != 0;
            const Signs exact = exact_signs(cases[i]);
            const bool wrong = exact.orientation <= 0 || ((verdict & outside) != 0 && exact.side <= 0) ||
                               ((verdict & inside) != 0 && exact.side >= 0) ||
                               ((verdict & pruned) != 0 && exact.side > 0);
            if (!wrong) continue;
            if (counts.wrong++ == 0) {
                counts.first = "verdict " + std::to_string(verdict) + ", orientation " +
                               std::to_string(exact.orientation) + ", side " + std::to_string(exact.side) +
                               ", distance " + std::to_string(std::log10(cases[i].distance)) + ", units";
                for (const std::uint64_t word : words(cases[i])) counts.first.append(" ").append(std::to_string(word));
            }
        }
    }
    return counts;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu filter: nothing is decided or left out against the exact sign") {
        test::Gpu gpu;
        for (const bool float64 : {false, true}) {
            if (float64 && !gpu.device->has_float64()) continue;
            for (const unsigned bits : {0u, 1u, 2u, 3u, 6u, 7u}) {
                const bool lossy = (bits & 1) != 0, weights = (bits & 2) != 0, tilts = (bits & 4) != 0;
                CAPTURE(float64);
                CAPTURE(lossy);
                CAPTURE(weights);
                CAPTURE(tilts);
                const Counts counts = judge(gpu, {float64, lossy, float64 ? 1e-12 : 1e-4, 1, 57, weights, tilts}, 11);
                CHECK_MESSAGE(counts.wrong == 0, counts.first);
                // Both decided and undecided cases occur.
                CHECK(counts.vertices > test::by_size(50000, 2000));
                CHECK(counts.decided > counts.vertices / 15);
                CHECK(counts.decided < counts.vertices / 10 * 9);
                CHECK(counts.pruned > counts.vertices / 50);
            }
        }
    }

    // In float64 the bound of the vertex is of first order in the rounding to units, which may be far from small.
    TEST_CASE("gpu filter: rounded coordinates of small cells, at vertices of nearly one line") {
        test::Gpu gpu;
        if (!gpu.device->has_float64()) return;
        const Counts counts = judge(gpu, {true, true, 1e-12, 1e-6, SMALLEST_CELL_EXPONENT}, 12);
        CHECK_MESSAGE(counts.wrong == 0, counts.first);
        CHECK(counts.decided > counts.vertices / 15);
    }
}
