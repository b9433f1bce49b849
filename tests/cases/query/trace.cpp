// Diagram::trace() against exact lower envelopes, and against locate() along the rays.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;
using test::QueryCase;

// A time is numerator / denominator, in quanta of length over those of the direction.
struct Time {
    mpz_class numerator, denominator;
    friend bool operator<(const Time& a, const Time& b) {
        return a.numerator * b.denominator < b.numerator * a.denominator;
    }
    friend bool operator==(const Time& a, const Time& b) {
        return a.numerator * b.denominator == b.numerator * a.denominator;
    }
};

struct Row {
    std::vector<std::int32_t> seeds;
    std::vector<double> times;  // of the ends
    // For each piece, from each image of the seed that shares the ray.
    std::vector<std::vector<std::array<double, 3>>> middles;
};

constexpr int direction_quantum = -60;

// The power of seed and image at time t, less that of the origin: h - t slope.
struct Line {
    mpz_class h, slope;
    std::int32_t seed;
    test::Integers way;  // twice that from the origin to the image
};

// Returns the cells of a ray by all seeds and images, in integers. end: its last time.
Row envelope(const QueryCase& c, const std::vector<bool>& has_cell, const double* origin, const double* direction,
             double end) {
    const test::IntegerDomain domain = test::with_query(c, origin);
    const std::size_t q = domain.size() - 1;
    Row row;
    if (domain.is_outside(q)) return row;
    test::Integers d;
    for (std::size_t k = 0; k < 3; ++k) d[k] = mpz_class(std::ldexp(direction[k], -direction_quantum));
    std::vector<Line> lines;
    const auto& periodic = c.options.cell ? c.options.cell->periodic : c.options.periodic;
    std::array<int, 3> reach{}, shift{};
    for (std::size_t k = 0; k < 3; ++k) reach[k] = periodic[k] ? 3 : 0;
    for (std::size_t i = 0; i < q; ++i) {
        if (!has_cell[i]) continue;
        for (shift[0] = -reach[0]; shift[0] <= reach[0]; ++shift[0])
            for (shift[1] = -reach[1]; shift[1] <= reach[1]; ++shift[1])
                for (shift[2] = -reach[2]; shift[2] <= reach[2]; ++shift[2]) {
                    const test::IntegerPlane plane = domain.bisector(q, i, shift);
                    lines.push_back({plane.h, test::dot(plane.n, d), static_cast<std::int32_t>(i), plane.n});
                }
    }
    // A time of 1 is 2^-quantum of length over 2^-direction_quantum.
    Time stop{mpz_class(std::ldexp(end, 60)), 1};
    const int shift_of_unit = direction_quantum - domain.quantum() - 60;
    if (shift_of_unit >= 0)
        stop.numerator <<= static_cast<unsigned>(shift_of_unit);
    else
        stop.denominator <<= static_cast<unsigned>(-shift_of_unit);
    for (const test::IntegerPlane& wall : domain.walls(q)) {
        const mpz_class slope = test::dot(wall.n, d);
        if (slope > 0) stop = std::min(stop, Time{wall.h, slope});
    }
    if (lines.empty()) return row;
    const Line* at = &lines.front();
    for (const Line& line : lines)
        if (line.h < at->h || (line.h == at->h && line.slope > at->slope)) at = &line;
    Time now{0, 1};
    while (now < stop) {
        const Line* to = nullptr;
        Time next = stop;
        std::int32_t lowest = at->seed;
        for (const Line& line : lines) {
            if (line.h == at->h && line.slope == at->slope) lowest = std::min(lowest, line.seed);
            if (line.slope <= at->slope) continue;
            const Time time{line.h - at->h, line.slope - at->slope};
            if (!(time < next) && !(time == next && to != nullptr && line.slope > to->slope)) continue;
            next = time;
            to = &line;
        }
        const mpq_class exact(next.numerator, next.denominator);
        const mpq_class twice_middle = mpq_class(now.numerator, now.denominator) + exact;
        row.middles.emplace_back();
        for (const Line& line : lines) {
            if (line.seed != lowest || line.h != at->h || line.slope != at->slope) continue;
            auto& middle = row.middles.back().emplace_back();
            for (std::size_t k = 0; k < 3; ++k) {
                const mpq_class twice = twice_middle * d[k] - line.way[k];
                middle[k] = std::ldexp(twice.get_d(), domain.quantum() - 1);
            }
        }
        row.seeds.push_back(lowest);
        row.times.push_back(std::ldexp(exact.get_d(), domain.quantum() - direction_quantum));
        now = next;
        if (to == nullptr) break;
        at = to;
    }
    return row;
}

double length_of(const double* d) {
    return std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

double distance_of(const double* a, const double* b) {
    const double way[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length_of(way);
}

struct RaySet {
    Coordinates origins, directions;
    std::vector<double> lengths;
    [[nodiscard]] votess::RayCells trace(const votess::Diagram& diagram) const {
        return diagram.trace(origins, directions, lengths, {.middles = true});
    }
};

// Requires the seeds, the lengths, and middles that count from an image of the row.
void require_row(const Row& row, const votess::RayCells& cells, std::size_t ray, double length_of_direction) {
    const auto begin = static_cast<std::size_t>(cells.offsets[ray]),
               end = static_cast<std::size_t>(cells.offsets[ray + 1]);
    REQUIRE(std::ranges::equal(std::span(cells.seeds).subspan(begin, end - begin), row.seeds));
    double along = 0;
    for (std::size_t e = 0; e < row.seeds.size(); ++e) {
        const double* middle = &cells.middles[3 * (begin + e)];
        REQUIRE(std::ranges::any_of(row.middles[e], [&](const std::array<double, 3>& exact) {
            return distance_of(middle, exact.data()) < 1e-13;
        }));
        along += cells.lengths[begin + e];
        REQUIRE(std::abs(along - row.times[e] * length_of_direction) < 1e-13);
    }
}

// Requires that locate() agrees in the middle of each piece and at many points along each ray.
void check_march(const votess::Diagram& diagram, const RaySet& rays, const votess::RayCells& cells) {
    constexpr double near = 1e-10;
    constexpr int points_of_ray = 40;
    Coordinates queries;
    std::vector<std::int32_t> expected;
    const std::size_t count = rays.lengths.size();
    REQUIRE(cells.offsets.size() == count + 1);
    for (std::size_t r = 0; r < count; ++r) {
        const double* d = &rays.directions[3 * r];
        const auto add = [&](double along, std::int32_t seed) {
            for (std::size_t k = 0; k < 3; ++k)
                queries.push_back(rays.origins[3 * r + k] + along / length_of(d) * d[k]);
            expected.push_back(seed);
        };
        const auto begin = static_cast<std::size_t>(cells.offsets[r]),
                   end = static_cast<std::size_t>(cells.offsets[r + 1]);
        double from = 0;
        for (std::size_t e = begin; e < end; ++e) {
            const double to = from + cells.lengths[e];
            CHECK(cells.lengths[e] >= 0);
            if (cells.lengths[e] > near) add(0.5 * (from + to), cells.seeds[e]);
            for (int p = 0; p < points_of_ray; ++p) {
                const double along = rays.lengths[r] * (p + 0.37) / points_of_ray;
                if (along > from + near && along < to - near) add(along, cells.seeds[e]);
            }
            from = to;
        }
    }
    CHECK(diagram.locate(queries) == expected);
    CHECK(expected.size() > 5 * count);
}

using Vector = std::array<double, 3>;

struct Gradients {
    std::vector<double> values, gradients;
};

Gradients random_gradients(std::size_t seeds, std::uint64_t seed) {
    test::Random random(seed);
    Gradients field;
    for (std::size_t i = 0; i < seeds; ++i) field.values.push_back(random.uniform(-1, 1));
    for (std::size_t i = 0; i < 3 * seeds; ++i) field.gradients.push_back(random.uniform(-9, 9));
    return field;
}

// Requires that each middle counts from the nearest of all seeds and images, by power, and that integrate() agrees.
// lattice: vectors along x, in the xy plane, then anywhere; so short that shifts of 1 around the rounded one suffice.
void check_middles(const Coordinates& points, std::span<const double> weights, const std::vector<Vector>& lattice,
                   const RaySet& rays, const votess::RayCells& cells, double error) {
    const std::size_t n = points.size() / 3;
    const Gradients field = random_gradients(n, 6);
    std::vector<double> expected(rays.lengths.size());
    REQUIRE(cells.middles.size() == 3 * cells.seeds.size());
    const int images = lattice.empty() ? 1 : lattice.size() == 2 ? 9 : 27;
    double worst = 0;
    for (std::size_t r = 0; r < rays.lengths.size(); ++r) {
        const double* d = &rays.directions[3 * r];
        double from = 0;
        for (auto e = static_cast<std::size_t>(cells.offsets[r]); e < static_cast<std::size_t>(cells.offsets[r + 1]);
             ++e) {
            const double along = from + 0.5 * cells.lengths[e];
            from += cells.lengths[e];
            double best = std::numeric_limits<double>::infinity();
            Vector nearest{};
            std::size_t seed = 0;
            for (std::size_t i = 0; i < n; ++i) {
                Vector way;
                for (std::size_t k = 0; k < 3; ++k)
                    way[k] = rays.origins[3 * r + k] + along / length_of(d) * d[k] - points[3 * i + k];
                const auto move = [&](Vector& x, std::size_t v, double shift) {
                    for (std::size_t k = 0; k < 3; ++k) x[k] -= shift * lattice[v][k];
                };
                for (std::size_t v = lattice.size(); v-- > 0;) move(way, v, std::round(way[v] / lattice[v][v]));
                for (int code = 0; code < images; ++code) {
                    Vector moved = way;
                    int digits = code;
                    for (std::size_t v = 0; v < lattice.size(); ++v, digits /= 3) move(moved, v, digits % 3 - 1);
                    const double length = length_of(moved.data());
                    const double power = length * length - (weights.empty() ? 0 : weights[i]);
                    if (power >= best) continue;
                    best = power;
                    nearest = moved;
                    seed = i;
                }
            }
            double mean = field.values[seed];
            for (std::size_t k = 0; k < 3; ++k) mean += field.gradients[3 * seed + k] * nearest[k];
            expected[r] += mean * cells.lengths[e];
            if (cells.lengths[e] < 1e-9) continue;
            REQUIRE(seed == static_cast<std::size_t>(cells.seeds[e]));
            worst = std::max(worst, distance_of(nearest.data(), &cells.middles[3 * e]));
        }
    }
    CHECK(worst < error);
    const std::vector<double> integrals = cells.integrate(field.values, field.gradients);
    for (std::size_t r = 0; r < expected.size(); ++r) CHECK(std::abs(integrals[r] - expected[r]) < 20 * error);
}

// Requires the exact integral of a field that is linear everywhere.
void check_linear(const Coordinates& points, const RaySet& rays, const votess::RayCells& cells) {
    constexpr double slope[3] = {1.5, -2, 0.75};
    Gradients field;
    for (std::size_t i = 0; i < points.size(); i += 3) {
        field.values.push_back(0.5 + slope[0] * points[i] + slope[1] * points[i + 1] + slope[2] * points[i + 2]);
        field.gradients.insert(field.gradients.end(), slope, slope + 3);
    }
    const std::vector<double> integrals = cells.integrate(field.values, field.gradients);
    std::size_t passed = 0;
    for (std::size_t r = 0; r < integrals.size(); ++r) {
        double length = 0;  // in the domain
        for (std::int64_t e = cells.offsets[r]; e < cells.offsets[r + 1]; ++e)
            length += cells.lengths[static_cast<std::size_t>(e)];
        const double* d = &rays.directions[3 * r];
        double mean = 0.5;
        for (std::size_t k = 0; k < 3; ++k)
            mean += slope[k] * (rays.origins[3 * r + k] + 0.5 * length / length_of(d) * d[k]);
        CHECK(std::abs(integrals[r] - mean * length) < 1e-12);
        passed += length > 0 ? 1 : 0;
    }
    CHECK(2 * passed > integrals.size());
}

}  // namespace

TEST_SUITE("query") {
    TEST_CASE("trace: random domains and rays against exact envelopes") {
        test::Random random(5);
        std::size_t pieces = 0;
        for (std::size_t set = 0; set < test::by_size(150, 30); ++set) {
            CAPTURE(set);
            QueryCase c = test::random_query_case(random, set % 4 != 0);
            c.options.weights = c.weights;
            const votess::Tessellation t = votess::tessellate(c.points, c.options);
            std::vector<bool> has_cell;
            for (const votess::CellStatus status : t.status())
                has_cell.push_back(status == votess::CellStatus::certified);
            const votess::Diagram diagram(c.points, c.options);
            RaySet rays;
            constexpr int few = 4;
            constexpr double directions[8][3] = {{1, 0, 0}, {0, -3, 4}, {1, 2, -2}, {-1, -1, 0},
                                                 {1, 1, 1}, {0, 0, -1}, {0, 1, 0},  {0, 0, 0}};
            for (int r = 0; r < few; ++r) {
                const auto x = test::random_query(random, c, false);
                rays.origins.insert(rays.origins.end(), x.begin(), x.end());
                const auto kind = random.below(8);
                for (std::size_t k = 0; k < 3; ++k)
                    rays.directions.push_back(kind == 7 ? static_cast<double>(random.integer(-1000, 1000)) / 1024
                                                        : directions[kind][k] / 8);
                if (rays.directions.back() == 0 && length_of(&rays.directions[rays.directions.size() - 3]) == 0)
                    rays.directions.back() = 1;
                rays.lengths.push_back(static_cast<double>(random.below(9)) / 8);
            }
            const votess::RayCells cells = rays.trace(diagram);
            for (std::size_t r = 0; r < few; ++r) {
                CAPTURE(r);
                const double* d = &rays.directions[3 * r];
                const Row row = envelope(c, has_cell, &rays.origins[3 * r], d, rays.lengths[r] / length_of(d));
                require_row(row, cells, r, length_of(d));
                pieces += row.seeds.size();
            }
        }
        CHECK(pieces > test::by_size(600, 100));
    }

    TEST_CASE("trace: locate() agrees along 200 rays in each domain") {
        constexpr std::size_t count = 200;
        const test::PointSet set = test::uniform(400, 8);
        test::Random random(9);
        RaySet rays;
        for (std::size_t i = 0; i < 3 * count; ++i) rays.origins.push_back(random.uniform());
        for (std::size_t i = 0; i < 3 * count; ++i) rays.directions.push_back(random.uniform(-1, 1));
        for (std::size_t i = 0; i < count; ++i) rays.lengths.push_back(random.uniform(0.5, 3));
        std::vector<double> weights;
        for (std::size_t i = 0; i < 400; ++i) weights.push_back(random.uniform(-0.01, 0.01));
        for (int domain = 0; domain < 8; ++domain) {
            CAPTURE(domain);
            votess::Options options;
            options.box = test::unit_box();
            if (domain == 1 || domain == 2) options.periodic = {true, true, domain == 1};
            if (domain >= 5) options.weights = weights;
            if (domain == 3 || domain == 6) {
                options.box.reset();
                options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.25, 1}};
            }
            if (domain == 4) {
                options.walls = {{{1, 2, 0.7}, 2}, {{-1, 0.1, 0}, -0.05}};
                options.outside = votess::Outside::keep;
            }
            if (domain == 7) {  // so flat that seeds are moved into the reduced cell
                options.box.reset();
                options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {3.4, 1, 0}, {-2.3, 4.25, 1}};
            }
            const votess::Diagram diagram(set.points, options);
            const votess::RayCells cells = rays.trace(diagram);
            check_march(diagram, rays, cells);
            options.threads = 3;
            options.instructions = "baseline";
            const votess::RayCells again = rays.trace(votess::Diagram(set.points, options));
            CHECK(again.offsets == cells.offsets);
            CHECK(again.seeds == cells.seeds);
            CHECK(again.lengths == cells.lengths);
            CHECK(again.middles == cells.middles);
        }
        votess::Options options;  // all of space
        const votess::Diagram diagram(set.points, options);
        for (std::size_t i = 0; i < count; ++i) rays.origins[3 * i] += 2 * (static_cast<double>(i % 3) - 1);
        check_march(diagram, rays, rays.trace(diagram));
    }

    TEST_CASE("trace: a cell with hundreds of neighbors") {
        const test::PointSet set = test::on_sphere_and_center(400, 12);
        const auto center = std::span(set.points).last(3);
        test::Random random(13);
        RaySet rays;
        for (int r = 0; r < 50; ++r) {
            for (std::size_t k = 0; k < 3; ++k) rays.origins.push_back(center[k]);
            for (int k = 0; k < 3; ++k) rays.directions.push_back(random.uniform(-1, 1));
            rays.lengths.push_back(1.0);
        }
        for (const char* instructions : {"", "baseline"}) {
            votess::Options options;
            options.instructions = instructions;
            const votess::Diagram diagram(set.points, options);
            check_march(diagram, rays, rays.trace(diagram));
        }
    }

    TEST_CASE("trace: middles and linear fields in each domain") {
        const test::PointSet set = test::uniform(60, 18);
        test::Random random(19);
        RaySet rays;
        constexpr std::size_t count = 30;
        for (std::size_t i = 0; i < 3 * count; ++i) rays.origins.push_back(random.uniform());
        for (std::size_t i = 0; i < 3 * count; ++i) rays.directions.push_back(random.uniform(-1, 1));
        for (std::size_t i = 0; i < count; ++i) rays.lengths.push_back(random.uniform(0.5, 3));
        std::vector<double> weights;
        for (std::size_t i = 0; i < 60; ++i) weights.push_back(random.uniform(-0.03, 0.03));
        struct Domain {
            const char* name;
            votess::Options options;
            std::vector<Vector> lattice;
            double periods = 0;  // of origins, beyond the domain
        };
        std::vector<Domain> domains(6);
        domains[0].name = "box";
        domains[0].options.box = test::unit_box();
        domains[1].name = "walls";
        domains[1].options.box = test::unit_box();
        domains[1].options.walls = {{{1, 2, 0.7}, 2}, {{-1, 0.1, 0}, -0.05}};
        domains[1].options.outside = votess::Outside::keep;
        domains[2].name = "all of space";
        domains[3].name = "slab";
        domains[3].options.box = test::unit_box();
        domains[3].options.periodic = {true, true, false};
        domains[3].lattice = {{1, 0, 0}, {0, 1, 0}};
        domains[4].name = "triclinic";  // so flat that seeds are moved into the reduced cell
        domains[4].options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {3.4, 1, 0}, {-2.3, 4.25, 1}};
        domains[4].lattice = {{1, 0, 0}, {0.4, 1, 0}, {0.1, 0.25, 1}};
        domains[5] = domains[4];
        domains[5].name = "triclinic, many periods away";
        domains[5].periods = 1e5;
        for (const Domain& domain : domains) {
            for (const bool weighted : {false, true}) {
                CAPTURE(domain.name);
                CAPTURE(weighted);
                Coordinates points = set.points;
                RaySet moved = rays;
                for (std::size_t i = 0; i < points.size() && domain.periods > 0; i += 3) points[i] += 7;
                for (std::size_t i = 0; i < moved.origins.size(); i += 3) moved.origins[i] += domain.periods;
                votess::Options options = domain.options;
                if (weighted) options.weights = weights;
                const votess::RayCells cells = moved.trace(votess::Diagram(points, options));
                if (domain.lattice.empty()) check_linear(points, moved, cells);
                if (domain.options.walls.empty())
                    check_middles(points, options.weights, domain.lattice, moved, cells,
                                  1e-13 + 1e-15 * domain.periods);
            }
        }
    }

    TEST_CASE("trace: lattices in random order against exact envelopes") {
        test::Random random(12);
        for (const bool periodic : {false, true}) {
            CAPTURE(periodic);
            for (int set = 0; set < 6; ++set) {
                CAPTURE(set);
                test::PointSet lattice = periodic ? test::bcc(2) : set < 3 ? test::cubic(4) : test::fcc(2);
                lattice = test::reordered(lattice, test::Order::shuffled, static_cast<std::uint64_t>(set + 1));
                QueryCase c;
                c.points = lattice.points;
                c.options.box = lattice.box;
                c.options.periodic = {periodic, periodic, periodic};
                const votess::Diagram diagram(c.points, c.options);
                RaySet rays;
                const std::size_t count = periodic ? 8 : 20;
                for (std::size_t r = 0; r < count; ++r) {
                    for (std::size_t k = 0; k < 3; ++k)
                        rays.origins.push_back(lattice.box->lower[k] + static_cast<double>(random.below(4)) / 2);
                    for (int k = 0; k < 3; ++k) rays.directions.push_back(static_cast<double>(random.integer(-1, 2)));
                    if (length_of(&rays.directions[3 * r]) == 0) rays.directions.back() = 1;
                    rays.lengths.push_back(periodic ? 2.5 : 8);
                }
                const votess::RayCells cells = rays.trace(diagram);
                const std::vector<bool> all(c.points.size() / 3, true);
                for (std::size_t r = 0; r < count; ++r) {
                    CAPTURE(r);
                    const double* d = &rays.directions[3 * r];
                    const Row row = envelope(c, all, &rays.origins[3 * r], d, rays.lengths[r] / length_of(d));
                    require_row(row, cells, r, length_of(d));
                }
            }
        }
    }

    // Rays graze the faces between seeds that are far nearer than others.
    TEST_CASE("trace: tight clusters against exact envelopes") {
        test::Random random(31);
        std::size_t pieces = 0;
        for (std::size_t set = 0; set < test::by_size(120, 24); ++set) {
            CAPTURE(set);
            const int spread = -static_cast<int>(4 + random.below(28));
            QueryCase c;
            c.options.box = test::unit_box();
            std::array<std::array<double, 3>, 3> centers;
            for (auto& center : centers)
                for (double& x : center) x = static_cast<double>(random.integer(2, 14)) / 16;
            for (std::size_t i = 0; i < 6 + random.below(14); ++i)
                for (std::size_t k = 0; k < 3; ++k)
                    c.points.push_back(centers[i % 3][k] +
                                       std::ldexp(static_cast<double>(random.integer(-1024, 1024)), spread - 10));
            const votess::Diagram diagram(c.points, c.options);
            RaySet rays;
            constexpr std::size_t count = 6;
            for (std::size_t r = 0; r < count; ++r) {
                for (int k = 0; k < 3; ++k) rays.origins.push_back(static_cast<double>(random.integer(0, 1024)) / 1024);
                for (int k = 0; k < 3; ++k)
                    rays.directions.push_back(static_cast<double>(random.integer(-1000, 1000)) / 1024);
                rays.lengths.push_back(1);
            }
            const votess::RayCells cells = rays.trace(diagram);
            const std::vector<bool> all(c.points.size() / 3, true);
            for (std::size_t r = 0; r < count; ++r) {
                CAPTURE(r);
                const double length = length_of(&rays.directions[3 * r]);
                const Row row = envelope(c, all, &rays.origins[3 * r], &rays.directions[3 * r], 1 / length);
                require_row(row, cells, r, length);
                pieces += row.seeds.size();
            }
        }
        CHECK(pieces > test::by_size(1000, 200));
    }

    TEST_CASE("trace: rays without cells, and refusals") {
        const test::PointSet set = test::uniform(50, 2);
        votess::Options options;
        options.box = test::unit_box();
        const votess::Diagram diagram(set.points, options);
        const double far = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
        using Numbers = std::vector<double>;
        const auto trace = [&](const Numbers& origin, const Numbers& direction, const Numbers& length) {
            return diagram.trace(origin, direction, length);
        };
        CHECK(trace({}, {}, {}).offsets == std::vector<std::int64_t>{0});
        CHECK(trace({2, 0.5, 0.5}, {-1, 0, 0}, {5}).seeds.empty());   // begins outside
        CHECK(trace({1, 0.5, 0.5}, {1, 0, 0}, {5}).seeds.empty());    // leaves at once
        CHECK(trace({0.5, 0.5, 0.5}, {1, 0, 0}, {0}).seeds.empty());  // without length
        CHECK(votess::Diagram().trace(Numbers{0, 0, 0}, Numbers{1, 0, 0}, Numbers{1}).offsets ==
              std::vector<std::int64_t>{0, 0});
        const auto refused = [&](const Numbers& origin, const Numbers& direction, const Numbers& length) {
            try {
                (void)trace(origin, direction, length);
            } catch (const votess::Error& error) {
                return std::string(error.what());
            }
            return std::string("accepted");
        };
        const Numbers x{0.5, 0.5, 0.5}, d{1, 0, 0};
        CHECK(refused(x, {1, nan, 0}, {1}) == "ray 0: component nan of its direction is not finite");
        CHECK(refused(x, {0, 0, 0}, {1}) == "ray 0: its direction is 0: give another vector");
        CHECK(refused(x, d, {-2}) == "ray 0: its length -2 is not 0 or more: give lengths");
        CHECK(refused(x, d, {nan}) == "ray 0: its length nan is not 0 or more: give lengths");
        CHECK(refused({0.5, far, 0.5}, d, {1}) == "query 0: coordinate inf is not finite");
        CHECK(refused(x, d, {1, 2}).starts_with("there are 1 origins, but 1 directions and 2 lengths"));
        CHECK(refused(x, {1e300, 1e-300, 0}, {1}).starts_with("ray 0: component 1e-300 of its direction is too small"));
        options.periodic = {true, false, false};
        const votess::Diagram tube(set.points, options);
        CHECK_THROWS_AS((void)tube.trace(x, d, Numbers{far}), votess::Error);
        CHECK(tube.trace(x, Numbers{1, 1e-3, 0}, Numbers{far}).seeds.size() > 100);  // many times around
        // A mistake in a length is refused before it takes memory, wherever its ray is among others.
        votess::Options tilted;
        tilted.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.25, 1}};
        const votess::Diagram torus(set.points, tilted);
        for (const votess::Diagram* repeats : {&tube, &torus})
            for (const double length : {1e9, 1e18, 1e300}) {
                std::string message;
                CHECK(test::error_of(
                          [&] {
                              (void)repeats->trace(Numbers{0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, Numbers{1, 0, 0, 1, 0, 0},
                                                   Numbers{1, length});
                          },
                          &message) == votess::ErrorCode::unsupported);
                CHECK(message.starts_with("ray 1: its length 1"));
                CHECK(
                    message.ends_with("leads through more than 16777216 cells: give a shorter length, or shorter "
                                      "rays one after the other"));
            }
        CHECK(torus.trace(x, d, Numbers{1000}).seeds.size() > 1000);
        CHECK_THROWS_AS((void)trace(x, d, {1}).integrate(Numbers{1}), votess::Error);
        CHECK(trace(x, d, {1}).middles.empty());
        CHECK_THROWS_AS((void)trace(x, d, {1}).integrate(Numbers(50), Numbers(150)), votess::Error);  // without middles
        const votess::RayCells cells = diagram.trace(x, d, Numbers{1}, {.middles = true});
        CHECK(cells.integrate(Numbers(50), Numbers(150)) == Numbers{0});
        CHECK_THROWS_AS((void)cells.integrate(Numbers(50), Numbers(50)), votess::Error);
    }
}
