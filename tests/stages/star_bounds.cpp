// star: the bounds of star_bounds.hpp against rationals, where rounding is as bad as they allow, and as it is.
#include "walk/star_bounds.hpp"

#include <doctest/doctest.h>
#include <gmpxx.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "cpu/cpu_clipper.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/kernel_sets.hpp"
#include "support/rational_planes.hpp"
#include "walk/window.hpp"

using namespace votess::cpu;
using test::Random;
using Vector = std::array<double, 3>;

namespace {

double decades(Random& random, double lower, double upper) {
    return std::pow(10, random.uniform(lower, upper));
}

Vector direction(Random& random) {
    Vector v;
    double square;
    do {
        square = 0;
        for (double& x : v) x = random.uniform(-1, 1), square += x * x;
    } while (square < 0.01 || square > 1);
    for (double& x : v) x /= std::sqrt(square);
    return v;
}

double length_of(const Vector& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

mpq_class square_of(const mpq_class& x) {
    return x * x;
}

// A seed at the origin in a small cell among heavy seeds that are far away, and light ones that are not.
struct Small {
    std::vector<double> points{0, 0, 0}, weights;
    Small(Random& random, double size) {
        weights.push_back(random.chance(0.5) ? 0 : random.uniform(-3, 3));
        const double largest = decades(random, -2, 0);
        for (int i = 0; i < 14; ++i) {
            const bool near = random.chance(0.2);
            const double r = near ? size * random.uniform(0.5, 3) : largest * random.uniform(0.3, 1);
            const double h = size * random.uniform(0.5, 1.5);
            const Vector d = direction(random);
            double square = 0;
            for (const double x : d) points.push_back(r * x), square += points.back() * points.back();
            weights.push_back(weights[0] + square - 2 * h * r);
        }
    }
    [[nodiscard]] test::RationalPlane plane(std::size_t i) const {
        test::RationalPlane plane;
        plane.h = (mpq_class(weights[0]) - mpq_class(weights[i])) / 2;
        for (std::size_t k = 0; k < 3; ++k) {
            plane.n[k] = mpq_class(points[3 * i + k]) - mpq_class(points[k]);
            plane.h += plane.n[k] * plane.n[k] / 2;
        }
        return plane;
    }
};

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("star bounds: no seed that cuts a vertex off is beyond its reach") {
        Random random(1);
        for (std::size_t i = 0; i < test::by_size(6000, 2000); ++i) {
            const double x = decades(random, -12, 12), longest = x * decades(random, -1, 10);
            const double length = x + longest / 4;
            // Away from the seed, or towards it, by as much as (1) allows.
            const mpq_class off = mpq_class(0.6 * bounds::margin) * mpq_class(length) * (random.chance(0.8) ? 1 : -1);
            const mpq_class exact = mpq_class(x) + off;
            CHECK(mpq_class(bounds::max_distance(x, length)) >= exact);
            CHECK(mpq_class(bounds::max_square(x * x, length * length, 1)) >= exact * exact);
            const double tilt = longest * random.uniform(), sum = x + (longest + tilt) / 4;
            CHECK(bounds::weighted_length2(x * x, longest * longest, tilt * tilt) >=
                  sum * sum * (1 - 4 * bounds::unit));
            // By a metric in which vectors are up to so much longer.
            const double longer = decades(random, -2, 2);
            const mpq_class by_metric = mpq_class(x) + abs(off) * mpq_class(longer);
            CHECK(mpq_class(bounds::max_square(x * x, length * length, longer * longer)) >= by_metric * by_metric);
            double more = x * x * decades(random, -12, 12);
            if (random.chance(0.6)) more = -x * x * (1 - decades(random, -17, 0));
            const mpq_class square = exact * exact + mpq_class(more);
            if (square <= 0) continue;
            // The farthest seed that cuts X off, seen from x, is at sqrt(square) + |off|. The walk's test of its
            // distance is D^2 - 2 slack D < most^2 + more.
            const double most = bounds::max_distance(x, length), slack = 2 * bounds::margin * length;
            const mpq_class distance = mpq_class(std::sqrt(square.get_d()) * (1 - 0x1p-50)) + abs(off);
            CHECK(distance * distance - 2 * mpq_class(slack) * distance <
                  mpq_class(most) * mpq_class(most) + mpq_class(more));
        }
    }

    TEST_CASE("star bounds: the widest reach without weights") {
        Random random(2);
        for (std::size_t i = 0; i < test::by_size(6000, 2000); ++i) {
            const double x = decades(random, -6, 6);
            const mpq_class off = mpq_class(0.45 * bounds::margin) * mpq_class(x), exact = mpq_class(x) + off;
            CHECK(mpq_class(bounds::widest_reach(x * x)) >= exact + off);
            CHECK(mpq_class(bounds::widest_reach_squared(x * x)) >= 4 * exact * exact);
        }
    }

    TEST_CASE("star bounds: planes of seeds that the search skips are as far away as it says") {
        Random random(7);
        test::for_each_set([&](const StarKernels& kernels) {
            const BentKernels& bent = bent_kernels(kernels.name);
            std::size_t skipped = 0;
            for (std::size_t i = 0; i < test::by_size(20000, 4000); ++i) {
                const double extent = decades(random, 5, 8), distance = extent * decades(random, -3, -0.1);
                const double norm = extent * decades(random, -5, 0);
                const Vector along = direction(random);
                // The exact plane is a little nearer than the limit, or farther away.
                const double off =
                    random.chance(0.5) ? bounds::quantum * random.uniform(0, 3) : distance * random.uniform(-1, 1);
                std::int32_t at[3][16];
                Vector n;
                double norm2 = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    at[k][0] = static_cast<std::int32_t>(std::lrint(norm * along[k]));
                    n[k] = at[k][0] + random.uniform(-1.01, 1.01);
                    norm2 += n[k] * n[k];
                    for (int j = 1; j < 16; ++j) at[k][j] = far_away;
                }
                // With a tilt of its own: turn.n / 2 more.
                const Vector aside = direction(random);
                const double turn = random.chance(0.5) ? 0 : extent * decades(random, -4, 1);
                BentLimits limits{{}, {1, 1, 1, 0, 0, 0}, {}};
                double turned = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    limits.turn[k] = static_cast<float>(turn * aside[k]);
                    turned += turn * aside[k] * n[k];
                }
                const double h = (distance - off) * std::sqrt(norm2), difference = 2 * h - norm2 - turned;  // r_p - r_q
                const double own = random.chance(0.5) ? 0 : difference * random.uniform(-2, 2),
                             other = own - difference;
                const double span = std::max({own, other, 0.0}) - std::min({own, other, 0.0});
                const double rounding =
                    bounds::weight_rounding(span, 0, extent) + bounds::turn_rounding(turn, 3.5 * extent);
                const double limit = 4 * distance * distance;
                const auto slack = static_cast<float>(bounds::select_slack(distance, extent, rounding));
                const std::int32_t zero[3] = {0, 0, 0};
                std::int32_t ids[16] = {7};
                float weights[16] = {static_cast<float>(other)};
                for (int j = 1; j < 16; ++j) weights[j] = -std::numeric_limits<float>::infinity();
                const auto candidates = std::make_unique<CandidatePlanes>();
                limits.near_squared = limits.distance_squared = static_cast<float>(limit);
                limits.slack = slack;
                const WindowSeeds seeds{at[0], at[1], at[2], ids, weights, 1};
                const auto weight = static_cast<float>(own);
                REQUIRE((turn == 0 ? kernels.select(seeds, zero, weight, limits, *candidates)
                                   : bent.select_bent(seeds, zero, weight, limits, *candidates)));
                skipped += candidates->count == 0 ? 1 : 0;
                if (candidates->count == 0) CHECK(h / std::sqrt(norm2) >= distance * (1 - 0x1p-20) - bounds::quantum);
            }
            CHECK(skipped > 500);
        });
    }

    TEST_CASE("star bounds: powers and back") {
        Random random(3);
        for (std::size_t i = 0; i < test::by_size(6000, 2000); ++i) {
            const double square = decades(random, -20, 20), sign = random.chance(0.5) ? 1 : -1;
            const double weight =
                random.chance(0.3) ? square * random.uniform(0.9, 1.1) : sign * decades(random, -20, 20);
            const double power = bounds::power(square, weight);
            CHECK(mpq_class(power) >= mpq_class(square) - mpq_class(weight));
            CHECK(bounds::back(power, weight) >= square);
            const double other = decades(random, -20, 20), other_weight = -sign * decades(random, -20, 20);
            const double largest = std::max(power, bounds::power(other, other_weight));
            CHECK(bounds::back(largest, std::max(weight, other_weight)) >= std::max(square, other));
        }
    }

    // Cells much smaller than the normals of their faces.
    TEST_CASE("star bounds: vertices and powers of cells among heavy seeds") {
        Random random(4);
        std::size_t vertices = 0, beyond_length = 0;
        for (std::uint64_t i = 0; i < test::by_size(300, 60); ++i) {
            const double size = decades(random, -13, -1);
            const Small small(random, size);
            votess::Options options;
            options.box = test::cube(-4, 4);
            options.weights = small.weights;
            const votess::Job job = votess::make_job(votess::settle({small.points, {}}, options));
            CpuClipper clipper;
            clipper.begin(job);
            clipper.prepare();
            const auto& input = clipper.seeds().input;
            const auto seed = static_cast<std::size_t>(std::ranges::find(input, 0) - input.begin());
            REQUIRE(seed < input.size());
            const std::size_t group = seed / Window::home_seeds * Window::home_groups;
            const WeightBlock& slopes = clipper.hierarchy().weight_bounds(0, group / box_fan);
            const double tilt = 0.5 * length_of({slopes.slope[0][group % box_fan], slopes.slope[1][group % box_fan],
                                                 slopes.slope[2][group % box_fan]});
            for (const Kernels* kernels : supported_kernels()) {
                const auto star = make_star(kernels->name, clipper.seeds(), clipper.hierarchy());
                star->begin_job(*job.domain);
                star->begin(seed / Star::alignment * Star::alignment, seed + 1, Star::Keep::places);
                if (!star->build(seed) || star->faces().empty()) continue;
                std::vector<std::uint32_t> ranks;
                for (const std::int32_t id : star->faces())
                    ranks.push_back(static_cast<std::uint32_t>(
                        std::ranges::count_if(star->faces(), [id](auto other) { return other < id; })));
                CellPolygons polygons;
                star->polygons(ranks, polygons);
                std::vector<std::vector<std::size_t>> faces_of(polygons.positions.size());
                bool walled = false;
                std::vector<test::RationalPlane> planes;
                for (std::size_t f = 0; f < polygons.size(); ++f) {
                    const std::int32_t id = star->faces()[f];
                    walled |= id < 0;
                    if (id >= 0) planes.push_back(small.plane(static_cast<std::size_t>(input[id])));
                    for (const std::uint32_t v : polygons.face(f)) faces_of[v].push_back(f);
                }
                if (walled) continue;
                for (std::size_t v = 0; v < faces_of.size(); ++v) {
                    const auto& faces = faces_of[v];
                    test::RationalVector exact;
                    if (faces.size() != 3 || !test::solve(planes[faces[0]], planes[faces[1]], planes[faces[2]], exact))
                        continue;
                    ++vertices;
                    double longest = 0;
                    for (const std::size_t f : faces)
                        longest = std::max(longest, length_of({planes[f].n[0].get_d(), planes[f].n[1].get_d(),
                                                               planes[f].n[2].get_d()}));
                    mpq_class off, square;
                    for (std::size_t k = 0; k < 3; ++k) {
                        off += square_of(exact[k] - mpq_class(polygons.positions[v][k]));
                        square += square_of(exact[k]);
                    }
                    const double length = length_of(polygons.positions[v]) + longest / 4 + 1.25 * tilt;
                    CHECK(off <= square_of(mpq_class(0.6 * bounds::margin * length)));
                    beyond_length += off > square_of(mpq_class(bounds::margin)) * square ? 1 : 0;
                    CHECK(mpq_class(star->power_found()) >= square - mpq_class(small.weights[0]));
                }
            }
        }
        CHECK(vertices > 500);
        if (!test::reduced()) CHECK(beyond_length > 10);  // what a bound in units of |X| would have missed
    }

    TEST_CASE("star bounds: no candidate plane that cuts a vertex off is passed over") {
        Random random(5);
        test::for_each_set([&](const StarKernels& kernels) {
            for (std::size_t i = 0; i < test::by_size(8000, 2000); ++i) {
                const double longest = decades(random, 0.3, random.chance(0.5) ? 1.5 : 8.5);
                const bool weighted = random.chance(0.4);
                // The seed exactly, and as whole numbers, off by up to half a unit each, as its own place is.
                const Vector along = direction(random);
                const double size = longest * (random.chance(0.5) ? 1 - 1e-7 : random.uniform(0, 1));
                std::int32_t at[3][16];
                Vector n;
                double norm2 = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    at[k][0] = static_cast<std::int32_t>(size * along[k]);
                    n[k] =
                        at[k][0] + (random.chance(0.8) ? std::copysign(1.0078, along[k]) * (random.chance(0.5) ? 1 : -1)
                                                       : random.uniform(-1, 1));
                    norm2 += n[k] * n[k];
                    for (int j = 1; j < 16; ++j) at[k][j] = far_away;
                }
                // A vertex on the plane, or a little beyond.
                const double span = weighted ? norm2 * decades(random, -4, 3) : 0;
                double own = 0, other = 0;
                if (weighted)
                    own = random.uniform(0, span), other = random.chance(0.5) ? 0 : own - random.uniform(0, span);
                const double low = std::min({0.0, own, other}), high = std::max({0.0, own, other});
                const mpq_class h = (mpq_class(n[0]) * n[0] + mpq_class(n[1]) * n[1] + mpq_class(n[2]) * n[2] +
                                     mpq_class(own) - mpq_class(other)) /
                                    2;
                if (h < 0 || norm2 == 0) continue;
                const double to_plane = h.get_d() / norm2;
                const Vector side = direction(random);
                const double shift = std::sqrt(norm2) * (random.chance(0.5) ? 0 : random.uniform(0, 3));
                Vector x;
                for (std::size_t k = 0; k < 3; ++k) x[k] = to_plane * n[k] * (1 + 0x1p-45) + shift * side[k];
                const double along_n = (x[0] * n[0] + x[1] * n[1] + x[2] * n[2]) / norm2;
                for (std::size_t k = 0; k < 3; ++k) x[k] += (to_plane * (1 + 0x1p-44) - along_n) * n[k];
                if (mpq_class(n[0]) * x[0] + mpq_class(n[1]) * x[1] + mpq_class(n[2]) * x[2] < h) continue;

                const double x2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
                // Floats cannot hold its square, or the search skips a seed at distance 0.
                if (h > 1e18 || (weighted && at[0][0] == 0 && at[1][0] == 0 && at[2][0] == 0)) continue;
                const double tilt = weighted && random.chance(0.5) ? longest * decades(random, -2, 2) : 0;
                const double off = 0.19 * bounds::float_unit * (std::sqrt(x2) + (weighted ? (longest + tilt) / 4 : 0));
                const auto m =
                    weighted ? bounds::float_margin(longest, tilt, bounds::weight_rounding(high - low, tilt, longest))
                             : bounds::float_margin(longest);
                float v[4];
                for (std::size_t k = 0; k < 3; ++k) v[k] = static_cast<float>(x[k] - off * n[k] / std::sqrt(norm2));
                v[3] = static_cast<float>(m.by_square * x2 + m.constant);
                const std::int32_t zero[3] = {0, 0, 0}, three[3] = {-1, -1, -1};
                std::int32_t ids[16] = {7};
                float weights[16] = {static_cast<float>(other)};
                const WindowSeeds window{at[0], at[1], at[2], ids, weighted ? weights : nullptr, 1};
                const auto candidates = std::make_unique<CandidatePlanes>();
                REQUIRE(kernels.select(window, zero, static_cast<float>(own),
                                       {0, std::numeric_limits<float>::max() / 4, 0}, *candidates));
                const int found = kernels.touching(*candidates, candidates->count, v, three, 0);
                CHECK(found == 0);
            }
        });
    }

    TEST_CASE("star bounds: the rounding of images does not hide a seed in a ball") {
        Random random(6);
        const double r = 2 * std::sqrt(3.0) * bounds::image_rounding;
        test::for_each_set([&](const StarKernels& kernels) {
            const auto all_found = [&](double square) {
                const double distance = std::sqrt(square);
                bool all = true;
                for (std::size_t i = 0; i < test::by_size(8000, 2000); ++i) {
                    const Vector v = direction(random), from_middle = direction(random);
                    // On the sphere around X, many of them near the seed, where the test allows for least.
                    const double near = random.chance(0.5) ? 1 : random.uniform(0, 1);
                    Vector n, x;
                    double from_x = 0;
                    for (std::size_t k = 0; k < 3; ++k) n[k] = -near * v[k] + (1 - near) * from_middle[k];
                    const double size = length_of(n);
                    for (std::size_t k = 0; k < 3; ++k) {
                        n[k] = distance * v[k] + distance * n[k] / size * (1 - 0x1p-40);
                        x[k] = distance * v[k] * (1 - 0.45 * bounds::margin);
                        from_x += (n[k] - distance * v[k]) * (n[k] - distance * v[k]);
                    }
                    double seeds[3][8];
                    for (std::size_t k = 0; k < 3; ++k)
                        for (double& at : seeds[k]) at = n[k] + r * (n[k] - distance * v[k]) / std::sqrt(from_x);
                    double x2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
                    const GroupTest ball{{}, 1, x, 2 * bounds::margin * x2};
                    all &= kernels.inside_ball(seeds[0], seeds[1], seeds[2], ball, 0) == 0xff;
                }
                return all;
            };
            CHECK(all_found(bounds::min_image_vertex2));
            CHECK_FALSE(all_found(bounds::min_image_vertex2 / 2));
        });
    }
}
