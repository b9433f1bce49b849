// star: the vector loops of every instruction set against plain ones. Integer inputs make all sums exact, so that there
// a result must be equal; on others it may differ where rounding decides.
#include "kernels/star_kernels.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <set>
#include <vector>

#include "core/arithmetic.hpp"
#include "kernels/weight_bend.hpp"
#include "support/check.hpp"
#include "support/kernel_sets.hpp"
#include "support/random.hpp"

using namespace votess::cpu;
using test::Random;
using votess::infinity;

namespace {

int round_up(int count, int multiple) {
    return (count + multiple - 1) / multiple * multiple;
}

// Candidates with the padding that kernels rely on; what lies behind it would be found first.
struct Planes {
    std::unique_ptr<CandidatePlanes> c = std::make_unique<CandidatePlanes>();

    template <class Draw>
    Planes(int count, const Draw& draw) {
        c->count = count;
        for (int i = 0; i < CandidatePlanes::capacity + 16; ++i) {
            const bool real = i < count, padding = !real && i < round_up(count, 16);
            const std::array<float, 4> plane = real      ? draw()
                                               : padding ? std::array{0.f, 0.f, 0.f, CandidatePlanes::never}
                                                         : std::array{1.f, 1.f, 1.f, -1e20f};
            c->nx[i] = plane[0], c->ny[i] = plane[1], c->nz[i] = plane[2], c->h[i] = plane[3];
            c->id[i] = real ? 3 * i - 6 : -100;
        }
    }
};

double gap(const CandidatePlanes& c, int i, const float* v) {
    return double{c.h[i]} - double{c.nx[i]} * v[0] - double{c.ny[i]} * v[1] - double{c.nz[i]} * v[2];
}

float small_integer(Random& random, int largest = 4) {
    return static_cast<float>(random.integer(-largest, largest));
}

// Returns the least of D^2 less the excess that the bound of box i allows, at places along each axis.
double least_in_box(const BoxBlock& block, const WeightBlock& bounds, int i, const votess::Box& home,
                    const WeightTilt& tilt) {
    constexpr int steps = 200;
    double sum = tilt.base + tilt.least - bounds.top[i];
    for (int k = 0; k < 3; ++k) {
        const double lower = block.lower[k][i], upper = block.upper[k][i], center = 0.5 * (lower + upper);
        double least = infinity;
        for (int step = 0; step <= steps; ++step) {
            const double x = lower + (upper - lower) * step / steps;
            const double gap = std::max({0.0, home.lower[k] - x, x - home.upper[k]});
            least =
                std::min(least, gap * gap - bounds.slope[k][i] * (x - center) + tilt.slope[k] * (x - tilt.origin[k]));
        }
        sum += least;
    }
    return sum;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("star kernels: near_boxes") {
        Random random(1);
        for (int round = 0; round < 2000; ++round) {
            BoxBlock block;
            votess::Box home;
            const bool integers = round % 2 == 0, point = random.chance(0.5);
            auto draw = [&] { return integers ? static_cast<double>(random.integer(-4, 4)) : random.uniform(-4, 4); };
            for (int k = 0; k < 3; ++k) {
                std::tie(home.lower[k], home.upper[k]) = std::minmax({draw(), draw()});
                if (point) home.upper[k] = home.lower[k];
                for (int i = 0; i < box_fan; ++i)
                    std::tie(block.lower[k][i], block.upper[k][i]) = std::minmax({draw(), draw()});
            }
            const int existing = static_cast<int>(random.below(box_fan + 1));
            for (int i = existing; i < box_fan; ++i)
                for (int k = 0; k < 3; ++k) block.lower[k][i] = infinity, block.upper[k][i] = -infinity;
            const double limit = integers ? static_cast<double>(random.below(30)) : random.uniform(0, 30);
            unsigned near = 0, uncertain = 0;
            for (int i = 0; i < existing; ++i) {
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    const double apart =
                        std::max({0.0, block.lower[k][i] - home.upper[k], home.lower[k] - block.upper[k][i]});
                    sum += apart * apart;
                }
                near |= static_cast<unsigned>(sum < limit) << i;
                if (!integers && std::abs(sum - limit) <= 1e-14 * limit) uncertain |= 1u << i;
            }
            test::for_each_set([&](const StarKernels& kernels) {
                REQUIRE((kernels.near_boxes(block, home, limit) | uncertain) == (near | uncertain));
                REQUIRE(kernels.near_boxes(block, home, 1e300) == (1u << existing) - 1);
            });
        }
    }

    TEST_CASE("star kernels: list_bits") {
        for (unsigned mask = 0; mask < 256; ++mask) {
            std::vector<std::uint32_t> listed;
            for (unsigned k = 0; k < box_fan; ++k)
                if ((mask >> k) & 1) listed.push_back(4000000000 + k);
            test::for_each_set([&](const StarKernels& kernels) {
                std::array<std::uint32_t, box_fan> out;
                const int count = kernels.list_bits(mask, 4000000000, out.data());
                REQUIRE(std::vector(out.begin(), out.begin() + count) == listed);
            });
        }
    }

    TEST_CASE("star kernels: inside_ball") {
        Random random(2);
        for (int round = 0; round < 4000; ++round) {
            std::array<std::vector<double>, 3> q;
            GroupTest test{{}, std::ldexp(1.0, static_cast<int>(random.integer(-3, 3))), {}, 0};
            auto draw = [&] { return static_cast<double>(random.integer(-8, 8)); };
            for (int k = 0; k < 3; ++k) {
                test.p[k] = draw();
                test.v[k] = draw() * test.scale;
                for (int i = 0; i < box_fan; ++i) q[k].push_back(draw());
            }
            for (int i = box_fan - static_cast<int>(random.below(3)); i < box_fan; ++i)
                for (auto& axis : q) axis[i] = infinity;  // what follows the last seed
            if (random.chance(0.3)) test.slack = random.uniform(0, 3);
            const double least = random.chance(0.3) ? 0 : static_cast<double>(random.below(60));
            unsigned must = 0, may = 0;
            for (int i = 0; i < box_fan; ++i) {
                if (q[0][i] == infinity) continue;
                double square = 0, along = 0;
                for (int k = 0; k < 3; ++k) {
                    const double n = (q[k][i] - test.p[k]) * test.scale;
                    square += n * n;
                    along += n * test.v[k];
                }
                const bool far_enough = square >= least;
                must |= static_cast<unsigned>(far_enough && along - 0.5 * square + test.slack >= 0) << i;
                may |= static_cast<unsigned>(far_enough && along - 0.5 * square + test.slack >= -1e-7 * square) << i;
            }
            test::for_each_set([&](const StarKernels& kernels) {
                const unsigned inside = kernels.inside_ball(q[0].data(), q[1].data(), q[2].data(), test, least);
                REQUIRE((inside & must) == must);
                REQUIRE((inside & ~may) == 0);
            });
        }
    }

    // Seeds in boxes, with weights that are nearly linear in each, and a home with another slope. For a
    // home that is a place the test is sharp: no place in a box that passes it has less D^2 than the bound allows.
    TEST_CASE("star kernels: near_heavier and to_window keep all seeds that may cut") {
        Random random(2);
        int passed = 0, dropped = 0;
        for (int round = 0; round < 2000; ++round) {
            const double spread = random.chance(0.5) ? 0 : random.uniform(0, 2);  // of a box
            std::array<std::vector<double>, 3> seeds;
            std::vector<double> weights(box_fan * box_fan);
            BoxBlock block;
            WeightBlock bounds;
            WeightTilt tilt{};
            votess::Box home;
            const double length = random.chance(0.5) ? random.uniform(0, 1) : 0, square = random.uniform(0, 2),
                         nearest = random.chance(0.5) ? random.uniform(0, 5) : 0;
            for (int k = 0; k < 3; ++k) {
                seeds[k].resize(weights.size());
                home.lower[k] = random.uniform(-1, 0), home.upper[k] = random.uniform(0, 1);
                tilt.slope[k] = random.uniform(-3, 3), tilt.origin[k] = random.uniform(-1, 1);
            }
            if (random.chance(0.5)) home.upper = home.lower;
            tilt.base = random.uniform(-3, 3), tilt.least = random.uniform(-3, 3), tilt.largest = 8;
            const HeavierTest test(tilt, length, square, nearest);
            for (int i = 0; i < box_fan; ++i) {
                const double top = random.uniform(-9, 9);
                double center[3];
                for (int k = 0; k < 3; ++k) {
                    bounds.slope[k][i] = random.chance(0.5) ? tilt.slope[k] : random.uniform(-3, 3);
                    const double at = random.uniform(-6, 6);
                    for (int j = 0; j < box_fan; ++j) seeds[k][box_fan * i + j] = at + random.uniform(0, spread);
                    const auto begin = seeds[k].begin() + box_fan * i;
                    const auto [least, most] = std::minmax_element(begin, begin + box_fan);
                    block.lower[k][i] = *least, block.upper[k][i] = *most;
                    center[k] = 0.5 * (*least + *most);
                }
                bounds.top[i] = -infinity;
                for (int j = 0; j < box_fan; ++j) {
                    double along = 0;
                    for (int k = 0; k < 3; ++k) along += bounds.slope[k][i] * (seeds[k][box_fan * i + j] - center[k]);
                    weights[box_fan * i + j] = top + along - (spread == 0 ? 0 : random.uniform(0, 1));
                    bounds.top[i] = std::max(bounds.top[i], weights[box_fan * i + j] - along);
                }
                bounds.extend(static_cast<std::size_t>(i), {{block.lower[0][i], block.lower[1][i], block.lower[2][i]},
                                                            {block.upper[0][i], block.upper[1][i], block.upper[2][i]}});
            }
            // least: of the excess.
            const auto excess_over = [&](std::size_t s, double square, double nearest, double least,
                                         double nearer = 1) {
                double distance2 = 0, more = weights[s] - tilt.base - tilt.least;
                for (int k = 0; k < 3; ++k) {
                    const double x = seeds[k][s];
                    distance2 += std::pow(std::max({0.0, home.lower[k] - x, x - home.upper[k]}), 2);
                    more -= tilt.slope[k] * (x - tilt.origin[k]);
                }
                const double distance = nearer * std::max(std::sqrt(distance2), nearest);
                return square + std::max(least, more) - distance * distance + 2 * test.length * distance;
            };
            const WindowFrame frame{home, 0, {}, 1024, &tilt, test.length};
            std::vector<std::uint32_t> groups(box_fan);
            std::iota(groups.begin(), groups.end(), 0u);
            test::for_each_set([&](const StarKernels& kernels) {
                const unsigned near = kernels.near_heavier(block, bounds, home, test);
                for (int i = 0; i < box_fan; ++i) {
                    double most = -infinity, at_least = -infinity, surely = -infinity;
                    for (int j = 0; j < box_fan; ++j) {
                        const auto s = static_cast<std::size_t>(box_fan * i + j);
                        most = std::max(most, excess_over(s, test.square, test.nearest, 0));
                        at_least = std::max(at_least, excess_over(s, test.square, test.nearest, -infinity));
                        surely = std::max(surely, excess_over(s, test.square, test.nearest, 0, 0.7));
                    }
                    if (at_least > 1e-9) REQUIRE((near >> i & 1) == 1);
                    if (spread == 0 && surely < -1e-9) REQUIRE((near >> i & 1) == 0);
                    if (test.length == 0 && test.nearest == 0 && home.lower == home.upper && (near >> i & 1) == 1)
                        CHECK(least_in_box(block, bounds, i, home, tilt) < test.square + 1e-3);
                    (most > 0 ? passed : dropped) += 1;
                }
                std::array<std::vector<std::int32_t>, 3> out;
                std::vector<std::int32_t> ids(weights.size() + 16);
                std::vector<float> residuals(ids.size());
                for (auto& axis : out) axis.resize(ids.size());
                std::int32_t* const to[3] = {out[0].data(), out[1].data(), out[2].data()};
                const int count =
                    kernels.to_window({{seeds[0].data(), seeds[1].data(), seeds[2].data()}, weights.data(), groups, 0},
                                      frame, to, ids.data(), residuals.data());
                std::vector<bool> kept(weights.size(), false);
                for (int w = 0; w < count; ++w) {
                    const auto s = static_cast<std::size_t>(ids[w]);
                    kept[s] = true;
                    double rest = weights[s] - tilt.base;
                    for (int k = 0; k < 3; ++k) rest -= tilt.slope[k] * (seeds[k][s] - tilt.origin[k]);
                    REQUIRE(std::abs(residuals[w] / (1024.0 * 1024) - rest) < 1e-5);
                }
                for (std::size_t s = 0; s < kept.size(); ++s) {
                    if (excess_over(s, 0, 0, -infinity) > 1e-9) REQUIRE(kept[s]);
                    if (excess_over(s, 0, 0, 0, 0.7) < -1e-9) REQUIRE(!kept[s]);
                }
            });
        }
        CHECK(passed > 2000);
        CHECK(dropped > 2000);
    }

    // Homes and boxes of seeds whose weights are a quadratic function and noise. The bounds of boxes know neither.
    TEST_CASE("star kernels: near_bent and to_bent_window keep all seeds whose planes are near") {
        Random random(21);
        int kept = 0, dropped = 0, kept_seeds = 0, dropped_seeds = 0;
        for (int round = 0; round < 4000; ++round) {
            // Eigenvalues up to `steepest`, on turned axes.
            WeightBend bent{};
            bent.steepest = random.uniform(0.05, 0.95);
            std::array<std::array<double, 3>, 3> axes{};
            for (std::size_t a = 0; a < 3; ++a) {
                double along = 0;
                for (double& x : axes[a]) x = random.uniform(-1, 1);
                for (std::size_t b = 0; b < a; ++b) {
                    along = axes[a][0] * axes[b][0] + axes[a][1] * axes[b][1] + axes[a][2] * axes[b][2];
                    for (std::size_t k = 0; k < 3; ++k) axes[a][k] -= along * axes[b][k];
                }
                const double length = std::hypot(axes[a][0], axes[a][1], axes[a][2]);
                for (double& x : axes[a]) x /= length;
                const double value = random.chance(0.5) ? bent.steepest * 0.999 : random.uniform(-2, bent.steepest);
                for (std::size_t i = 0; i < 3; ++i)
                    for (std::size_t j = 0; j < 3; ++j) bent.bend[i][j] += value * axes[a][i] * axes[a][j];
            }
            for (std::size_t i = 0; i < 3; ++i) {
                double others = 0;
                for (std::size_t j = 0; j < 3; ++j) {
                    bent.largest = std::max(bent.largest, std::abs(bent.bend[i][j]));
                    if (j != i) others += std::abs(bent.bend[i][j]);
                }
                bent.downward[i] = std::max(0.0, others - bent.bend[i][i]);
            }
            WeightTilt tilt{};
            tilt.base = random.uniform(-3, 3);
            for (int k = 0; k < 3; ++k) tilt.slope[k] = random.uniform(-3, 3), tilt.origin[k] = random.uniform(-1, 1);
            const double noise = random.chance(0.5) ? 0 : random.uniform(0, 1), length = random.uniform(0, 1);
            using Place = std::array<double, 3>;
            const auto quadratic = [&](const Place& x) {
                double sum = tilt.base;
                for (std::size_t i = 0; i < 3; ++i) {
                    sum += tilt.slope[i] * (x[i] - tilt.origin[i]);
                    for (std::size_t j = 0; j < 3; ++j)
                        sum += bent.bend[i][j] * (x[i] - tilt.origin[i]) * (x[j] - tilt.origin[j]);
                }
                return sum;
            };
            std::array<Place, 4> home_seeds;
            std::array<double, 4> home_weights{};
            votess::Box home{{9, 9, 9}, {-9, -9, -9}};
            tilt.least = infinity;
            for (std::size_t s = 0; s < home_seeds.size(); ++s) {
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = home_seeds[s][k] = tilt.origin[k] + random.uniform(-0.4, 0.4);
                    home.lower[k] = std::min(home.lower[k], x), home.upper[k] = std::max(home.upper[k], x);
                }
                const double rho = noise * random.uniform(-1, 1);
                home_weights[s] = quadratic(home_seeds[s]) + rho;
                tilt.least = std::min(tilt.least, rho - 1e-12);
                double square = 0;
                for (std::size_t k = 0; k < 3; ++k)
                    for (std::size_t j = 0; j < 3; ++j)
                        square += (home_seeds[s][k] - tilt.origin[k]) * (home_seeds[s][j] - tilt.origin[j]) *
                                  ((k == j ? 1 : 0) - bent.bend[k][j]);
                bent.radius = std::max(bent.radius, std::sqrt(square) * (1 + 1e-12));
            }
            for (const double slope : tilt.slope) bent.steepest_slope = std::max(bent.steepest_slope, std::abs(slope));
            BoxBlock block;
            WeightBlock bounds;
            std::array<bool, box_fan> must{};
            std::array<std::vector<double>, 4> all;  // coordinates and weights of the seeds of all boxes
            std::vector<bool> must_seed;
            for (std::size_t i = 0; i < box_fan; ++i) {
                std::array<Place, 4> seeds;
                std::array<double, 4> weights{};
                Place center{}, least{9, 9, 9}, most{-9, -9, -9};
                const double spread = random.chance(0.3) ? 0 : random.uniform(0, 2);
                Place at;
                for (double& x : at) x = random.uniform(-3, 3);
                for (auto& x : seeds)
                    for (std::size_t k = 0; k < 3; ++k) {
                        x[k] = at[k] + random.uniform(0, spread);
                        least[k] = std::min(least[k], x[k]), most[k] = std::max(most[k], x[k]);
                    }
                for (std::size_t k = 0; k < 3; ++k) {
                    block.lower[k][i] = least[k], block.upper[k][i] = most[k];
                    center[k] = 0.5 * (least[k] + most[k]);
                    bounds.slope[k][i] = tilt.slope[k] + random.uniform(-0.5, 0.5);
                    for (std::size_t j = 0; j < 3; ++j)
                        bounds.slope[k][i] += 2 * bent.bend[k][j] * (center[j] - tilt.origin[j]);
                }
                bounds.top[i] = -infinity;
                for (std::size_t s = 0; s < seeds.size(); ++s) {
                    weights[s] = quadratic(seeds[s]) + noise * random.uniform(-1, 1);
                    double rest = weights[s];
                    for (std::size_t k = 0; k < 3; ++k) rest -= bounds.slope[k][i] * (seeds[s][k] - center[k]);
                    bounds.top[i] = std::max(bounds.top[i], rest + 1e-12);
                    for (std::size_t k = 0; k < 3; ++k) all[k].push_back(seeds[s][k]);
                    all[3].push_back(weights[s]);
                    must_seed.push_back(false);
                    for (std::size_t p = 0; p < home_seeds.size(); ++p) {
                        double square = 0, bends = 0, excess = weights[s] - home_weights[p];
                        for (std::size_t k = 0; k < 3; ++k) {
                            const double n = seeds[s][k] - home_seeds[p][k];
                            square += n * n;
                            excess -= tilt.slope[k] * n;
                            for (std::size_t j = 0; j < 3; ++j) {
                                excess -= 2 * bent.bend[k][j] * (home_seeds[p][j] - tilt.origin[j]) * n;
                                bends += bent.bend[k][j] * n * (seeds[s][j] - home_seeds[p][j]);
                            }
                        }
                        if (square - 2 * length * std::sqrt(square - bends) < excess - 1e-9)
                            must[i] = must_seed.back() = true;
                    }
                }
            }
            const std::size_t missing = random.below(box_fan);
            if (random.chance(0.2)) {
                must[missing] = false;
                for (int k = 0; k < 3; ++k) block.lower[k][missing] = infinity, block.upper[k][missing] = -infinity;
                bounds.top[missing] = -infinity;
            }
            test::for_each_set([&](const StarKernels& kernels) {
                const unsigned near = bent_kernels(kernels.name).near_bent(block, bounds, tilt, bent, length);
                for (std::size_t i = 0; i < box_fan; ++i) {
                    if (must[i]) REQUIRE((near >> i & 1) == 1);
                    if (block.lower[0][i] == infinity) REQUIRE((near >> i & 1) == 0);
                    ((near >> i & 1) != 0 ? kept : dropped) += 1;
                }
                constexpr std::array<std::uint32_t, 4> groups{0, 1, 2, 3};
                const GroupSource source{{all[0].data(), all[1].data(), all[2].data()}, all[3].data(), groups, 0};
                const BentFrame frame{
                    {home, 0, {tilt.origin[0], tilt.origin[1], tilt.origin[2]}, 1e4, &tilt, length}, &tilt, &bent};
                std::array<std::array<std::int32_t, 64>, 4> out;
                std::array<float, 64> residuals;
                std::int32_t* const at[3] = {out[0].data(), out[1].data(), out[2].data()};
                const auto& to_window = bent_kernels(kernels.name).to_bent_window;
                const int count = to_window(source, frame, at, out[3].data(), residuals.data());
                std::vector<bool> found(must_seed.size(), false);
                for (int k = 0; k < count; ++k)
                    found[static_cast<std::size_t>(out[3][static_cast<std::size_t>(k)])] = true;
                for (std::size_t s = 0; s < found.size(); ++s) {
                    if (must_seed[s]) REQUIRE(found[s]);
                    (found[s] ? kept_seeds : dropped_seeds) += 1;
                }
            });
        }
        CHECK(kept > 5000);
        CHECK(dropped > 5000);
        CHECK(kept_seeds > 20000);
        CHECK(dropped_seeds > 20000);
    }

    TEST_CASE("star kernels: to_window selects, rounds and clamps") {
        Random random(3);
        constexpr double range = window_range;
        for (int round = 0; round < 400; ++round) {
            const std::size_t all = 40;
            const bool integers = round % 2 == 0;  // distances are exact, so that the limit is too
            std::array<std::vector<double>, 3> seeds;
            WindowFrame frame{
                {}, integers ? static_cast<double>(random.below(200)) : random.uniform(0, 200), {}, 1, nullptr, 0};
            frame.scale = std::ldexp(1.0, static_cast<int>(random.integer(0, 28)));
            auto draw = [&](double size) {
                return integers ? static_cast<double>(random.integer(-10, 10)) : random.uniform(-size, size);
            };
            for (int k = 0; k < 3; ++k) {
                frame.origin[k] = random.uniform(-10, 10);
                std::tie(frame.home.lower[k], frame.home.upper[k]) = std::minmax({draw(5), draw(5)});
                for (std::size_t i = 0; i < all * box_fan; ++i) seeds[k].push_back(draw(random.chance(0.2) ? 1e3 : 10));
            }
            for (std::size_t i = all * box_fan - 3; i < all * box_fan; ++i)
                for (auto& axis : seeds) axis[i] = infinity;
            std::vector<std::uint32_t> groups(random.below(all + 1));
            for (auto& group : groups) group = static_cast<std::uint32_t>(random.below(all));
            const std::size_t kept = random.below(std::min<std::size_t>(groups.size(), 2) + 1);
            std::vector<std::int32_t> expected;
            for (std::size_t i = 0; i < groups.size() * box_fan; ++i) {
                const std::size_t seed = groups[i / box_fan] * box_fan + i % box_fan;
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    const double x = seeds[k][seed];
                    const double gap = std::max({0.0, frame.home.lower[k] - x, x - frame.home.upper[k]});
                    sum += gap * gap;
                }
                if (i / box_fan < kept || sum < frame.distance_squared) expected.push_back(static_cast<int>(seed));
                if (!integers) REQUIRE(std::abs(sum - frame.distance_squared) > 1e-12);  // no matter of rounding
            }
            test::for_each_set([&](const StarKernels& kernels) {
                // Exactly as long as the window makes them, for the address sanitizer.
                const std::size_t room = groups.size() * box_fan + 16;
                std::array<std::vector<std::int32_t>, 3> out;
                for (auto& axis : out) axis.resize(room);
                std::vector<std::int32_t> ids(room);
                std::int32_t* const to[3] = {out[0].data(), out[1].data(), out[2].data()};
                const int count =
                    kernels.to_window({{seeds[0].data(), seeds[1].data(), seeds[2].data()}, nullptr, groups, kept},
                                      frame, to, ids.data(), nullptr);
                REQUIRE(std::equal(expected.begin(), expected.end(), ids.begin(), ids.begin() + count));
                for (int i = 0; i < count; ++i)
                    for (int k = 0; k < 3; ++k) {
                        const double x = seeds[k][static_cast<std::size_t>(ids[i])];
                        const double exact = (x - frame.origin[k]) * frame.scale;
                        if (std::abs(exact) <= range)
                            REQUIRE(std::abs(out[k][i] - exact) <= 0.5 + 1e-7);  // ties go either way
                        else
                            REQUIRE(std::abs(out[k][i]) == window_range);
                    }
            });
        }
    }

    TEST_CASE("star kernels: select keeps the order, the capacity and the padding") {
        Random random(4);
        for (int round = 0; round < 600; ++round) {
            const int count = static_cast<int>(random.below(641));
            const std::size_t readable = static_cast<std::size_t>(round_up(count, 16));
            const int size = random.chance(0.5) ? 20 : window_range;
            std::array<std::vector<std::int32_t>, 3> x;
            std::vector<std::int32_t> ids(readable, -1);
            for (auto& axis : x) {
                axis.assign(readable, far_away);
                for (int i = 0; i < count; ++i) axis[i] = static_cast<std::int32_t>(random.integer(-size, size));
            }
            for (int i = 0; i < count; ++i) {
                ids[i] = i;
                if (random.chance(0.05)) x[0][i] = far_away;  // hidden
            }
            const std::int32_t p[3] = {static_cast<std::int32_t>(random.integer(-size / 2, size / 2)), 1, -2};
            std::vector<double> square;
            for (int i = 0; i < count; ++i) {
                double sum = 0;
                for (int k = 0; k < 3; ++k) sum += std::pow(static_cast<double>(x[k][i] - p[k]), 2);
                square.push_back(sum);
            }
            // A limit that so many are below; half of the time about as many as there is room for.
            std::vector<double> sorted = square;
            std::sort(sorted.begin(), sorted.end());
            const auto wanted =
                random.chance(0.5) ? CandidatePlanes::capacity - 16 + random.below(24) : random.below(400);
            const double limit_wanted =
                sorted.empty() ? 100 : std::min(sorted[std::min(wanted, sorted.size() - 1)], 3.0 * size * size);
            const auto limit = static_cast<float>(limit_wanted);
            const bool weighted = random.chance(0.5);
            std::vector<float> weights(readable, 0);
            for (float& weight : weights) weight = static_cast<float>(random.integer(0, size));
            const auto own_weight = static_cast<float>(random.integer(0, size));
            const auto near_limit = static_cast<float>(random.uniform(0, 1.2)) * limit;
            // The square of twice the distance of the plane, with its sign.
            const auto measured = [&](int i, double less) {
                if (!weighted) return square[i] * (1 - less);
                const double h = 0.5 * (square[i] + own_weight - weights[i]) - less * (square[i] + size);
                return square[i] == 0 ? (h < 0 ? -infinity : infinity) : 4 * h * std::abs(h) / square[i];
            };
            std::vector<int> inside, edge;  // for certain, and where the rounding of floats decides
            for (int i = 0; i < count; ++i) {
                if (weighted && x[0][i] == far_away) continue;
                const double rounding = size == 20 && !weighted ? 0 : 1e-6;
                if (measured(i, -rounding) < limit * (1 - rounding))
                    inside.push_back(i);
                else if (measured(i, rounding) < limit * (1 + rounding))
                    edge.push_back(i);
            }
            for (int i = 0; i < count; ++i)
                if (x[0][i] == far_away) weights[i] = -std::numeric_limits<float>::infinity();
            std::fill(weights.begin() + count, weights.end(), -std::numeric_limits<float>::infinity());
            test::for_each_set([&](const StarKernels& kernels) {
                const auto planes = std::make_unique<CandidatePlanes>();
                CandidatePlanes& c = *planes;
                const bool fits = kernels.select(
                    {x[0].data(), x[1].data(), x[2].data(), ids.data(), weighted ? weights.data() : nullptr, count}, p,
                    own_weight, {near_limit, limit, 0}, c);
                // A set may give up when the last vector of seeds might not fit.
                if (inside.size() + edge.size() <= CandidatePlanes::capacity - 8) REQUIRE(fits);
                if (inside.size() > CandidatePlanes::capacity) REQUIRE_FALSE(fits);
                if (!fits) return;
                std::vector<int> found(c.id, c.id + c.count), sure;
                // Both parts ascend, and what is near stands in the first.
                REQUIRE((c.near >= 0 && c.near <= c.count));
                REQUIRE(std::is_sorted(found.begin(), found.begin() + c.near));
                REQUIRE(std::is_sorted(found.begin() + c.near, found.end()));
                for (int i = c.near; i < c.count; ++i) REQUIRE(measured(c.id[i], -1e-6) * (1 + 1e-6) >= near_limit);
                std::ranges::sort(found);
                std::ranges::set_difference(found, edge, std::back_inserter(sure));
                REQUIRE(sure == inside);
                for (int i = 0; i < c.count; ++i) {
                    const int s = c.id[i];
                    REQUIRE(c.nx[i] == static_cast<float>(x[0][s] - p[0]));
                    REQUIRE(c.ny[i] == static_cast<float>(x[1][s] - p[1]));
                    REQUIRE(c.nz[i] == static_cast<float>(x[2][s] - p[2]));
                    const double more = weighted ? double{own_weight} - weights[s] : 0;
                    REQUIRE(std::abs(c.h[i] - 0.5 * (square[s] + more)) <= 5e-7 * (square[s] + size));
                }
                for (int i = c.count; i < round_up(c.count, 16); ++i) {
                    REQUIRE((c.nx[i] == 0 && c.ny[i] == 0 && c.nz[i] == 0));
                    REQUIRE(c.h[i] == CandidatePlanes::never);
                }
            });
        }
    }

    TEST_CASE("star kernels: select at its capacity") {
        constexpr int capacity = CandidatePlanes::capacity, most = capacity + 44, places = 2 * most + 16;
        for (int near = 0; near <= most; near += near < capacity - 26 ? 23 : 1) {
            // The near ones all in front, or spread.
            for (const int step : {1, 2}) {
                std::vector<std::int32_t> x(places, far_away), zero(places, 0), ids(places);
                std::iota(ids.begin(), ids.end(), 7);
                for (int i = 0; i < near; ++i) x[i * step] = 1 + i;
                test::for_each_set([&](const StarKernels& kernels) {
                    const auto c = std::make_unique<CandidatePlanes>();
                    const std::int32_t p[3] = {0, 0, 0};
                    const bool fits = kernels.select(
                        {x.data(), zero.data(), zero.data(), ids.data(), nullptr, 2 * most}, p, 0, {1e6f, 1e6f, 0}, *c);
                    CAPTURE(near);
                    if (near <= CandidatePlanes::capacity - 8) REQUIRE(fits);
                    if (near > CandidatePlanes::capacity) REQUIRE_FALSE(fits);
                    if (!fits) return;
                    REQUIRE(c->count == near);
                    for (int i = 0; i < near; ++i) REQUIRE((c->id[i] == 7 + i * step && c->nx[i] == 1 + i));
                });
            }
        }
    }

    TEST_CASE("star kernels: first_hits") {
        Random random(5);
        for (int round = 0; round < 3000; ++round) {
            const bool integers = round % 2 == 0;
            auto draw = [&] { return integers ? small_integer(random) : static_cast<float>(random.uniform(-4, 4)); };
            const int count = static_cast<int>(round < 256 ? round + 1 : 1 + random.below(256));
            const Planes planes(count, [&] {
                return std::array{draw(), draw(), draw(), integers ? 8 + small_integer(random, 12) : 8 + draw()};
            });
            const CandidatePlanes& c = *planes.c;
            Ray rays[2];
            for (Ray& ray : rays) {
                ray = {};
                for (int k = 0; k < 3; ++k) ray.o[k] = draw(), ray.d[k] = draw();
                ray.limit = integers ? static_cast<float>(random.below(3)) : static_cast<float>(random.uniform(0, 2));
                // Among planes that are all parallel to the ray, or met from behind, there is none to hit.
                if (random.chance(0.1)) ray.d[0] = ray.d[1] = ray.d[2] = 0;
                if (random.chance(0.1)) ray.limit = 1e6f;
            }
            test::for_each_set([&](const StarKernels& kernels) {
                int hits[2] = {-7, -7};
                const int number = 1 + round % 2;
                kernels.first_hits(c, count, rays, number, hits);
                if (number == 1) REQUIRE(hits[1] == -7);
                for (int r = 0; r < number; ++r) {
                    const auto& [o, d, least] = rays[r];
                    auto leaving = [&](int i) {
                        return double{c.nx[i]} * d[0] + double{c.ny[i]} * d[1] + double{c.nz[i]} * d[2];
                    };
                    auto time = [&](int i) { return gap(c, i, o) / leaving(i); };  // when o + t d is on the plane
                    const double doubt = integers ? 0 : 1e-4;
                    double nearest = infinity;
                    for (int i = 0; i < count; ++i)
                        if (leaving(i) > least + doubt) nearest = std::min(nearest, time(i));
                    if (hits[r] == -1) {
                        REQUIRE(nearest == infinity);
                        continue;
                    }
                    REQUIRE((hits[r] >= 0 && hits[r] < count));
                    REQUIRE(leaving(hits[r]) > least - doubt);
                    const double rounding = 0x1p-12 * std::abs(nearest) + 1e-3 / leaving(hits[r]);
                    REQUIRE(time(hits[r]) <= nearest + rounding);
                }
            });
        }
    }

    TEST_CASE("star kernels: touching") {
        Random random(6);
        for (int round = 0; round < 1000; ++round) {
            const int count = static_cast<int>(round < 256 ? round + 1 : 1 + random.below(256));
            const Planes planes(count, [&] {
                return std::array{small_integer(random), small_integer(random), small_integer(random),
                                  40 + small_integer(random, 20)};
            });
            const CandidatePlanes& c = *planes.c;
            const float v[4] = {small_integer(random), small_integer(random), small_integer(random),
                                static_cast<float>(random.integer(-5, 20))};
            std::int32_t three[3];
            for (auto& id : three) id = c.id[random.below(static_cast<std::uint64_t>(count))];
            auto touches = [&](int i) {
                return gap(c, i, v) <= v[3] && std::find(three, three + 3, c.id[i]) == three + 3;
            };
            for (int begin = 0; begin <= count; ++begin) {
                int expected = begin;
                while (expected < count && !touches(expected)) ++expected;
                if (expected == count) expected = -1;
                test::for_each_set([&](const StarKernels& kernels) {
                    REQUIRE(kernels.touching(c, count, v, three, begin) == expected);
                });
                begin += count > 40 ? static_cast<int>(random.below(20)) : 0;
            }
        }
    }

    TEST_CASE("star kernels: rank") {
        Random random(7);
        for (int count = 0; count <= 130; ++count)
            for (int round = 0; round < 5; ++round) {
                std::vector<std::int32_t> sorted;
                const std::int64_t size = round == 0 ? 2 * count : std::numeric_limits<std::int32_t>::max();
                while (sorted.size() < static_cast<std::size_t>(count)) {
                    for (int i = 0; i < count; ++i)
                        sorted.push_back(static_cast<std::int32_t>(random.integer(round == 1 ? -size - 1 : -6, size)));
                    if (round == 2) sorted.push_back(std::numeric_limits<std::int32_t>::max());
                    std::sort(sorted.begin(), sorted.end());
                    sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
                }
                sorted.erase(sorted.begin(), sorted.end() - count);
                const auto order = test::permutation(sorted.size(), random);
                std::vector<std::int32_t> ids;
                for (const std::size_t place : order) ids.push_back(sorted[place]);
                test::for_each_set([&](const StarKernels& kernels) {
                    std::vector<std::uint32_t> places(std::max<std::size_t>(order.size(), 32), 9999);
                    kernels.rank(ids.data(), count, places.data());
                    REQUIRE(std::equal(order.begin(), order.end(), places.begin()));
                });
            }
    }

    TEST_CASE("star_kernels: corners are ordered by their ranks, ascending, with fillers behind") {
        test::Random random(31);
        for (std::size_t round = 0; round < test::by_size(400, 100); ++round) {
            CellShape shape;
            shape.slots = static_cast<int>(random.integer(4, CellShape::max_planes));
            const int most = 2 * shape.slots - 4;
            std::vector<std::uint8_t> ranks(static_cast<std::size_t>(shape.slots));
            const auto order = test::permutation(ranks.size(), random);
            for (std::size_t k = 0; k < ranks.size(); ++k) shape.rank[k] = static_cast<std::uint8_t>(order[k]);
            std::set<std::array<int, 3>> expected;
            while (shape.corners < static_cast<int>(random.integer(1, most))) {
                std::array<int, 3> slots;
                for (int& slot : slots) slot = static_cast<int>(random.integer(0, shape.slots - 1));
                std::array<int, 3> three{shape.rank[slots[0]], shape.rank[slots[1]], shape.rank[slots[2]]};
                std::ranges::sort(three);
                if (three[0] == three[1] || three[1] == three[2] || !expected.insert(three).second) continue;
                shape.add_corner(static_cast<unsigned>(slots[0]), static_cast<unsigned>(slots[1]),
                                 static_cast<unsigned>(slots[2]));
            }
            test::for_each_set([&](const StarKernels& kernels) {
                CornerOrder found;
                kernels.order_corners(shape, found);
                std::size_t at = 0;
                for (const auto& three : expected) {
                    for (std::size_t p = 0; p < 3; ++p) REQUIRE(found.rank[p][at] == CornerOrder::rank_step * three[p]);
                    ++at;
                }
                for (std::size_t k = 0; k < CellShape::fillers; ++k)
                    for (std::size_t p = 0; p < 3; ++p)
                        REQUIRE(found.rank[p][at + k] ==
                                CornerOrder::rank_step * (CellShape::max_planes + static_cast<int>(p)));
            });
        }
    }
}
