// Many small seeded sets, full of ties and near-ties, against the exact diagram.
// VOTESS_FUZZ_SETS: how many; VOTESS_FUZZ_SEED: of the first set, the others follow. A failure prints the set, reduced
// to the fewest points that still fail, as source for a named case.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "support/check.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::Random;

struct Set {
    Coordinates points;
    std::optional<votess::Box> box;
};

constexpr int kinds = 13;
constexpr int tiny_kind = kinds;  // integers times 2^-300, for the extreme sets

// The neighbors of 0 are 5e-324 away, far beyond the scales of the rest: only the extreme sets have them.
double nudged(double x, Random& random, bool extreme = false) {
    if (random.chance(0.6) || (x == 0 && !extreme)) return x;
    return std::nextafter(x, random.chance(0.5) ? x + 1 + std::abs(x) : x - 1 - std::abs(x));
}

// One coordinate triple of a set of this kind. `size` is drawn once per set.
std::array<double, 3> draw(int kind, int size, Random& random) {
    const auto grid = [&] { return static_cast<double>(random.integer(0, size)); };
    switch (kind) {
        case 0:
            return {grid(), grid(), grid()};
        case 1:
            return {random.uniform(), random.uniform(), random.uniform()};
        case 2: {  // integers, or half-way between them
            const double half = random.chance(0.3) ? 0.5 : 0;
            return {grid() + half, grid() + half, grid() + half};
        }
        case 3:
            return {1e8 + grid() * 0x1p-20, 1e8 + grid() * 0x1p-20, -1e8 + grid() * 0x1p-20};
        case 4:
            return {1e8 + 1e-3 * random.uniform(), 1e8 + 1e-3 * random.uniform(), 1e8 + 1e-3 * random.uniform()};
        case 5:
            return {grid() * 1e-10, grid() * 1e-10, grid() * 1e-10};
        case 6:
            return {nudged(1 + grid(), random), nudged(1 + grid(), random), nudged(1 + grid(), random)};
        case 7: {  // on walls of [0, size]
            std::array<double, 3> p{random.uniform(0, size), random.uniform(0, size), random.uniform(0, size)};
            for (auto& x : p)
                if (random.chance(0.5)) x = random.chance(0.5) ? 0 : size;
            return p;
        }
        case 8: {  // a plane through integer points, or a line in it
            const double u = grid(), v = random.chance(0.3) ? 0 : grid();
            return {2 * u + 3 * v, -u, -v};
        }
        case 9: {  // integer points of a sphere of squared radius 9, nudged or not
            static constexpr int sphere[4][3] = {{3, 0, 0}, {2, 2, 1}, {1, 2, 2}, {2, 1, 2}};
            const auto& s = sphere[random.below(4)];
            std::array<double, 3> p;
            const auto turn = random.below(3);
            for (std::size_t a = 0; a < 3; ++a) p[a] = (random.chance(0.5) ? 1 : -1) * s[(a + turn) % 3];
            if (size % 2 == 0)
                for (auto& x : p) x = nudged(x, random);
            return p;
        }
        case 10: {  // scales over many decades
            const double scale = std::ldexp(1.0, -static_cast<int>(random.below(40)));
            return {scale * random.uniform(), scale * random.uniform(), scale * random.uniform()};
        }
        case 11: {  // tenths, rounded
            return {grid() * 0.1, grid() * 0.1, grid() * 0.1};
        }
        case 12: {  // few different coordinates close together: slabs and needles
            const double step = std::ldexp(1.0, -static_cast<int>(10 * random.below(6)));
            return {0.25 + (random.chance(0.5) ? step * 0.25 : 0), 0.5 + grid() * step * 0.01, 0.75};
        }
        default:
            return {grid() * 0x1p-300, grid() * 0x1p-300, grid() * 0x1p-300};
    }
}

Set make(std::uint64_t seed, bool extreme) {
    Random random(seed);
    const int kind = extreme && random.chance(0.5) ? tiny_kind : static_cast<int>(random.below(kinds));
    const int mixed_with = random.chance(extreme ? 0.5 : 0.15) ? static_cast<int>(random.below(3)) : kind;
    const int size = static_cast<int>(random.integer(1, 5));
    // Few seeds most of the time: the oracle's time grows with their cube.
    const auto n = random.chance(0.7) ? random.integer(2, 10) : random.integer(11, 24);
    Set set;
    for (std::int64_t i = 0; i < n; ++i) {
        auto p = draw(random.chance(0.8) ? kind : mixed_with, size, random);
        if (i > 0 && random.chance(0.1)) {  // a near-duplicate of an earlier one
            const auto j = 3 * random.below(static_cast<std::uint64_t>(i));
            for (std::size_t a = 0; a < 3; ++a) p[a] = nudged(set.points[j + a], random, extreme);
        }
        set.points.insert(set.points.end(), p.begin(), p.end());
    }
    // The default box; else one around the points that touches them, or with room.
    if (const auto how = random.below(3); how > 0) {
        votess::Box box;
        bool valid = true;
        for (std::size_t a = 0; a < 3; ++a) {
            box.lower[a] = box.upper[a] = set.points[a];
            for (std::size_t i = a; i < set.points.size(); i += 3) {
                box.lower[a] = std::min(box.lower[a], set.points[i]);
                box.upper[a] = std::max(box.upper[a], set.points[i]);
            }
            const double width = box.upper[a] - box.lower[a];
            if (how == 2) {
                box.lower[a] -= width * static_cast<double>(random.below(3)) / 2;
                box.upper[a] += width * static_cast<double>(random.below(3)) / 2;
            }
            valid = valid && box.lower[a] < box.upper[a];
        }
        if (valid) set.box = box;
    }
    return set;
}

std::string judge(const Coordinates& points, const votess::Options& options, bool may_refuse) {
    try {
        return test::check_exact(votess::tessellate(points, options), points);
    } catch (const votess::Error& error) {
        if (may_refuse && error.code() == votess::ErrorCode::invalid_argument) return "";
        return std::string("threw: ") + error.what();
    } catch (const std::exception& error) {
        return std::string("threw: ") + error.what();
    }
}

// First word: so that leaving out points does not drift from a wrong row to a volume in its last digits.
std::string kind_of(const std::string& failure) {
    return failure.substr(0, failure.find(' '));
}

// The box that the whole set got, so that it stays the same while points are left out.
votess::Box box_of(const Set& set, votess::Options options) {
    if (set.box) return *set.box;
    options.box.reset();
    return votess::tessellate(set.points, options).box();
}

void fuzz(std::uint64_t sets, bool extreme) {
    const auto first = test::environment("VOTESS_FUZZ_SEED", 1);
    int failures = 0;
    for (std::uint64_t seed = first; seed < first + sets && failures < 5; ++seed) {
        const Set set = make(seed, extreme);
        Random random(seed ^ 0x5eed);
        votess::Options options = test::all_options(set.box);
        options.threads = 1 + static_cast<unsigned>(random.below(3) / 2);
        constexpr unsigned grids[] = {0, 0, 1, 2, 5, 50};
        options.grid_resolution = grids[random.below(6)];
        INFO("seed " << seed);  // doctest prints it after a crash too
        const std::string wrong = judge(set.points, options, extreme);
        if (wrong.empty()) continue;
        ++failures;
        std::string source;
        try {
            options.box = box_of(set, options);
            const auto fewest = test::minimize(set.points, [&](const Coordinates& points) {
                return !points.empty() && kind_of(judge(points, options, extreme)) == kind_of(wrong);
            });
            source = judge(fewest, options, extreme) + '\n' + test::print_points(fewest, *options.box);
        } catch (const std::exception&) {
            source = test::print_points(set.points, set.box.value_or(votess::Box{}));
        }
        FAIL_CHECK("seed " << seed << ", grid_resolution " << options.grid_resolution << ", threads " << options.threads
                           << ": " << wrong << "\nfewest points: " << source);
    }
}

}  // namespace

TEST_SUITE("fuzz") {
    TEST_CASE("small sets equal the exact diagram") {
        fuzz(test::environment("VOTESS_FUZZ_SETS", test::by_size(1500, 300)), false);
    }

    TEST_CASE("small sets whose coordinates span hundreds of binary digits equal the exact diagram, or are refused") {
        fuzz(test::environment("VOTESS_FUZZ_SETS", test::by_size(1500, 300)) / 4, true);
    }
}
