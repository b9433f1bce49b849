// The images of a periodic domain on a device: all within the bounds that cells rely on, at their exact places.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "gpu/domain/periodic_part.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

using test::Coordinates;
using votess::gpu::PeriodicPart;

namespace {

mpz_class floor_of(const mpq_class& x) {
    mpz_class result;
    mpz_fdiv_q(result.get_mpz_t(), x.get_num_mpz_t(), x.get_den_mpz_t());
    return result;
}

mpq_class scaled(double x, int shift) {
    mpq_class result(x);
    if (shift >= 0)
        mpq_mul_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(shift));
    else
        mpq_div_2exp(result.get_mpq_t(), result.get_mpq_t(), static_cast<mp_bitcnt_t>(-shift));
    return result;
}

std::optional<PeriodicPart> part_of(const votess::Job& job) {
    const auto domain = votess::gpu::device_domain(job);
    if (!domain) return std::nullopt;
    votess::ThreadPool pool(2);
    return votess::gpu::periodic_part(job, *domain->images, 1u << 20, pool);
}

// Tries shifts up to `reach`. Returns the number of images; 0 when the device does not clip the job.
std::size_t check_part(const Coordinates& points, const votess::Options& options, int reach) {
    const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
    const std::size_t count = points.size() / 3;
    const auto part = part_of(job);
    if (!part) return 0;
    const votess::Domain& domain = *job.domain;
    const int shift = votess::gpu::Units::for_box(part->box).shift;
    std::array<std::array<mpq_class, 3>, 3> vector;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
            const auto& length = domain.lattice.vector[j][k];
            vector[j][k] = (mpq_class(length.high) + mpq_class(length.low)) * scaled(1 / job.scale, shift);
        }
    std::map<std::pair<std::size_t, std::array<int, 3>>, std::size_t> members;
    for (std::size_t m = 0; m < part->part.members.size(); ++m) {
        const auto& s = part->shifts[m];
        members[{static_cast<std::size_t>(part->part.members[m]), {s[0], s[1], s[2]}}] = m;
    }
    REQUIRE(members.size() == part->part.members.size());
    std::array<mpz_class, 3> origin;
    for (int k = 0; k < 3; ++k) origin[k] = floor_of(scaled(part->box.lower[k], shift));
    for (std::size_t i = 0; i < count; ++i) {
        const auto wrap = votess::wrap(
            domain, {points[3 * i] * job.scale, points[3 * i + 1] * job.scale, points[3 * i + 2] * job.scale});
        REQUIRE(wrap.has_value());
        std::array<int, 3> most{};
        for (std::size_t j = 0; j < 3; ++j) most[j] = options.cell || options.periodic[j] ? reach : 0;
        for (int a = -most[0]; a <= most[0]; ++a)
            for (int b = -most[1]; b <= most[1]; ++b)
                for (int c = -most[2]; c <= most[2]; ++c) {
                    const std::array<int, 3> by{a, b, c};
                    std::array<mpq_class, 3> x;
                    bool within = true;
                    for (int k = 0; k < 3; ++k) {
                        x[k] = scaled(points[3 * i + static_cast<std::size_t>(k)], shift);
                        for (int j = 0; j < 3; ++j) x[k] += vector[j][k] * ((*wrap)[j] + by[j]);
                        if ((part->part.bounded >> k & 1) == 0) continue;
                        within = within && x[k] >= origin[k] + mpz_class(part->part.lower[k]) &&
                                 x[k] <= origin[k] + mpz_class(part->part.upper[k]);
                    }
                    const auto found = members.find({i, by});
                    CAPTURE(i);
                    CAPTURE(a);
                    CAPTURE(b);
                    CAPTURE(c);
                    if (within) REQUIRE(found != members.end());
                    if (found == members.end()) continue;
                    for (std::size_t k = 0; k < 3; ++k) {
                        const mpz_class units(part->coordinates[3 * found->second + k]);
                        const auto is_floor = [&](const mpq_class& y) {
                            mpz_class floor = floor_of(y);
                            mpz_fdiv_r_2exp(floor.get_mpz_t(), floor.get_mpz_t(), 64);
                            return units == floor;
                        };
                        const mpq_class error = scaled(1, -30);
                        REQUIRE((is_floor(x[k]) || is_floor(x[k] - error) || is_floor(x[k] + error)));
                        // Cells rely on exact coordinates then.
                        if (!part->lossy) REQUIRE(x[k] == floor_of(x[k]));
                    }
                    members.erase(found);
                }
    }
    REQUIRE(members.empty());  // each is a tried image
    return part->part.members.size() - count;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu periodic part: boxes at the origin and far away, where images are no doubles") {
        test::Random random(31);
        std::size_t images = 0;
        for (std::size_t step = 0; step < 25; step += test::by_size(2, 6))
            for (int mask = 1; mask < 8; ++mask) {
                const int far = 2 * static_cast<int>(step);
                votess::Options options = test::all_options(test::unit_box());
                CAPTURE(far);
                CAPTURE(mask);
                for (int k = 0; k < 3; ++k) {
                    options.periodic[k] = (mask >> k & 1) != 0;
                    // Across a power of two, where the steps of doubles change.
                    options.box->lower[k] = far == 0 ? random.uniform(-1, 0) : std::ldexp(1.0, far) - random.uniform();
                    options.box->upper[k] = options.box->lower[k] + random.uniform(0.8, 1.2);
                }
                Coordinates points;
                for (int i = 0; i < 40; ++i)
                    for (int k = 0; k < 3; ++k)
                        points.push_back(std::clamp(random.uniform(options.box->lower[k], options.box->upper[k]),
                                                    options.box->lower[k], options.box->upper[k]));
                images += check_part(points, options, 3);
            }
        CHECK(images > test::by_size(5000, 1500));
    }

    TEST_CASE("gpu periodic part: triclinic boxes, seeds millions of periods away") {
        test::Random random(32);
        std::size_t images = 0;
        for (int set = 0; set < static_cast<int>(test::by_size(16, 8)); ++set) {
            votess::Options options = test::all_options(test::unit_box());
            options.box.reset();
            const double skew = set % 4 == 0 ? 1.5 : 0.5;
            options.cell = votess::TriclinicBox{{std::ldexp(1.0, set % 2 == 0 ? set : 46), 0.25, -3},
                                                {1, 0, 0},
                                                {random.uniform(-skew, skew), 1, 0},
                                                {random.uniform(-skew, skew), random.uniform(-skew, skew), 1}};
            Coordinates points;
            const double away = std::ldexp(1.0, set % 28);
            for (int i = 0; i < 20; ++i)
                for (int k = 0; k < 3; ++k)
                    points.push_back(options.cell->origin[static_cast<std::size_t>(k)] +
                                     (i % 2 == 0 ? random.uniform() : random.uniform(-away, away)));
            CAPTURE(set);
            images += check_part(points, options, 10);
        }
        CHECK(images > 500);
    }

    TEST_CASE("gpu periodic part: vectors that are no whole units, seeds of leaning cells in the reduced one") {
        test::Random random(33);
        std::size_t images = 0, lossy = 0, moved = 0;
        for (int set = 0; set < static_cast<int>(test::by_size(12, 8)); ++set) {
            votess::Options options = test::all_options(test::unit_box());
            options.box.reset();
            const double tiny = std::ldexp(1.0, -8 * (set % 5)), lean = set % 2 == 0 ? 0.4 : 3;
            options.cell = votess::TriclinicBox{{0.1, set % 3 == 0 ? 1e6 : 0, -3},
                                                {1, tiny * random.uniform(-0.1, 0.1), 0},
                                                {random.uniform(-lean, lean), 1, tiny * random.uniform(-0.1, 0.1)},
                                                {tiny * random.uniform(-0.1, 0.1), random.uniform(-0.4, 0.4), 1}};
            const votess::TriclinicBox& cell = *options.cell;
            Coordinates points;
            for (int i = 0; i < 6; ++i) {
                const double f[3] = {random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3)};
                for (std::size_t k = 0; k < 3; ++k)
                    points.push_back(cell.origin[k] + f[0] * cell.a[k] + f[1] * cell.b[k] + f[2] * cell.c[k]);
            }
            CAPTURE(set);
            images += check_part(points, options, 16);
            const votess::Job job = votess::make_job(votess::settle({points, {}}, options));
            const auto part = part_of(job);
            lossy += part && part->lossy;
            moved += part && !part->moves.empty();
        }
        CHECK(images > 300);
        CHECK(lossy > 2);
        CHECK(moved > (test::reduced() ? 0 : 2));
    }
}
