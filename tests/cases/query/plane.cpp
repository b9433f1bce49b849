// Queries of a Diagram in the plane, against half-planes clipped in rational numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "oracle/planar_cells.hpp"
#include "support/check.hpp"
#include "support/random.hpp"
#include "support/text.hpp"

namespace {

using test::at_infinity, test::exact_planar_cell, test::PlanarCell, test::PlanarSet, test::Random;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double size = 16;  // of the domains

// As random_planar_set(), or without some or all ends.
PlanarSet random_set(std::uint64_t number, Random& random) {
    PlanarSet set = test::random_planar_set(number);
    set.options.planar = true;
    set.options.threads = 1;
    if (number % 3 == 2 && !set.options.cell && set.options.walls.empty()) {
        // Few bits, so that all vertices lie within the oracle's square.
        for (double& x : set.points) x = std::round(8 * x) / 8;
        set.options.periodic = {};
        for (std::size_t k = 0; k < 2; ++k) {
            if (number % 2 == 0 || random.chance(0.5)) set.options.box->lower[k] = -infinity;
            if (number % 2 == 0 || random.chance(0.5)) set.options.box->upper[k] = infinity;
        }
    }
    return set;
}

votess::Options options_of(const PlanarSet& set) {
    votess::Options options = set.options;
    options.weights = set.weights;
    return options;
}

std::array<double, 2> random_query(Random& random, const PlanarSet& set) {
    std::array<double, 2> x{};
    const auto kind = random.below(4);
    const std::size_t n = set.points.size() / 2, i = random.below(n), j = random.below(n);
    for (std::size_t k = 0; k < 2; ++k) {
        const double p = set.points[2 * i + k], q = set.points[2 * j + k];
        x[k] = kind == 0   ? std::floor(16 * random.uniform(0, size)) / 16
               : kind == 1 ? static_cast<double>(random.below(16))
               : kind == 2 ? p
                           : 0.5 * (p + q);
    }
    if (set.options.cell && kind < 2) x[0] += x[1] / size * set.options.cell->b[0];
    return x;
}

bool is_inside(const PlanarSet& set, const std::array<double, 2>& x) {
    const votess::Options& o = set.options;
    for (std::size_t k = 0; k < 2 && o.box; ++k)
        if (!o.periodic[k] && !(x[k] >= o.box->lower[k] && x[k] <= o.box->upper[k])) return false;
    return std::ranges::all_of(o.walls, [&](const votess::Wall& wall) {
        return wall.normal[0] * mpq_class(x[0]) + wall.normal[1] * mpq_class(x[1]) <= wall.offset;
    });
}

// Returns the least power of a seed or its images at x.
mpq_class power_at(const PlanarSet& set, std::size_t seed, const std::array<double, 2>& x) {
    const votess::Options& o = set.options;
    const auto& periodic = o.cell ? o.cell->periodic : o.periodic;
    std::array<std::array<double, 2>, 2> edges{{{size, 0}, {0, size}}};
    if (o.cell) edges = {{{o.cell->a[0], o.cell->a[1]}, {o.cell->b[0], o.cell->b[1]}}};
    mpq_class least = -1;
    bool any = false;
    for (int s = periodic[0] ? -3 : 0; s <= (periodic[0] ? 3 : 0); ++s)
        for (int t = periodic[1] ? -3 : 0; t <= (periodic[1] ? 3 : 0); ++t) {
            mpq_class power = set.weights.empty() ? mpq_class(0) : -mpq_class(set.weights[seed]);
            for (std::size_t k = 0; k < 2; ++k) {
                const mpq_class d = mpq_class(set.points[2 * seed + k]) + s * mpq_class(edges[0][k]) +
                                    t * mpq_class(edges[1][k]) - mpq_class(x[k]);
                power += d * d;
            }
            if (!any || power < least) least = power;
            any = true;
        }
    return least;
}

std::int32_t nearest(const PlanarSet& set, const std::array<double, 2>& x) {
    std::int32_t best = -1;
    mpq_class least;
    for (std::size_t i = 0; 2 * i < set.points.size() && is_inside(set, x); ++i) {
        if (test::is_duplicate(set, i)) continue;
        const mpq_class power = power_at(set, i, x);
        if (best < 0 || power < least) least = power, best = static_cast<std::int32_t>(i);
    }
    return best;
}

PlanarSet with_query(const PlanarSet& set, const std::array<double, 2>& x, double weight) {
    PlanarSet with = set;
    with.points.insert(with.points.end(), x.begin(), x.end());
    if (!set.weights.empty()) with.weights.push_back(weight);
    return with;
}

// Returns what is wrong with the cell of a probe that is not at the place of a seed.
std::string check_probe(const votess::Tessellation& t, const PlanarCell& cell) {
    std::map<test::PlanarLabel, double> lengths;
    const bool open = cell.lengths.contains(at_infinity);
    double perimeter = 0;
    for (std::size_t e = 0; e < t.indices().size(); ++e) {
        const bool shifted = !t.shifts().empty();
        perimeter += t.face_areas()[e];
        if (open && t.indices()[e] < 0 && std::isnan(t.face_normals()[2 * e]))
            lengths[at_infinity] = infinity;
        else
            lengths[{t.indices()[e], shifted ? t.shifts()[2 * e] : 0, shifted ? t.shifts()[2 * e + 1] : 0}] =
                t.face_areas()[e];
        const auto first = static_cast<std::size_t>(t.face_offsets()[e]);
        if (!open && t.face_offsets()[e + 1] - t.face_offsets()[e] != 2) return "an edge has not two corners";
        if (open) continue;
        const std::int32_t from = t.face_vertices()[first], to = t.face_vertices()[first + 1];
        const double dx = t.vertices()[2 * to] - t.vertices()[2 * from],
                     dy = t.vertices()[2 * to + 1] - t.vertices()[2 * from + 1];
        if (std::abs(std::hypot(dx, dy) - t.face_areas()[e]) > 1e-9) return "the corners of an edge are wrong";
    }
    if (lengths.size() != cell.lengths.size())
        return std::to_string(lengths.size()) + " edges, not " + std::to_string(cell.lengths.size());
    for (const auto& [label, length] : cell.lengths) {
        if (!lengths.contains(label)) return "no edge with " + std::to_string(std::get<0>(label));
        if (!open && std::abs(lengths[label] - length) > 1e-9) return "an edge has a wrong length";
    }
    if (t.face_counts()[0] != cell.lengths.size()) return "a wrong number of edges";
    if (open) return std::isinf(t.volumes()[0]) && std::isinf(t.surface_areas()[0]) ? "" : "an open cell is finite";
    if (std::abs(t.volumes()[0] - cell.area.get_d()) > 1e-9) return "a wrong area";
    if (std::abs(t.surface_areas()[0] - perimeter) > 1e-12 * perimeter) return "a wrong perimeter";
    for (std::size_t k = 0; k < 2 && cell.area != 0; ++k)
        if (std::abs(t.centroids()[k] - mpq_class(cell.centroid[k] / cell.area).get_d()) > 1e-8)
            return "a wrong centroid";
    return "";
}

votess::Want everything() {
    votess::Want want;
    want.centroids = want.counts = want.areas = want.normals = want.surfaces = want.radii = want.faces = true;
    return want;
}

// Sibson's: the areas that the query takes. Laplace's: lengths over distances.
std::map<std::int32_t, double> exact_weights(const PlanarSet& set, const PlanarSet& with, const PlanarCell& cell,
                                             votess::NaturalMethod method) {
    std::map<std::int32_t, double> weights;
    const std::size_t n = set.points.size() / 2;
    double sum = 0;
    if (method == votess::NaturalMethod::sibson) {
        for (std::size_t i = 0; i < n; ++i) {
            const mpq_class share = exact_planar_cell(set, i).area - exact_planar_cell(with, i).area;
            if (share > 0) weights[static_cast<std::int32_t>(i)] = mpq_class(share / cell.area).get_d();
        }
        return weights;
    }
    const votess::Options& o = set.options;
    for (const auto& [label, length] : cell.lengths) {
        const auto [seed, s, t] = label;
        if (seed < 0) continue;
        std::array<double, 2> d{};
        for (std::size_t k = 0; k < 2; ++k)
            d[k] = with.points[2 * static_cast<std::size_t>(seed) + k] - with.points[2 * n + k] +
                   s * (o.cell   ? o.cell->a[k]
                        : k == 0 ? size
                                 : 0) +
                   t * (o.cell   ? o.cell->b[k]
                        : k == 1 ? size
                                 : 0);
        weights[seed] += length / std::hypot(d[0], d[1]);
        sum += length / std::hypot(d[0], d[1]);
    }
    for (auto& [seed, weight] : weights) weight /= sum;
    return weights;
}

}  // namespace

TEST_SUITE("query") {
    TEST_CASE("plane: queries in all domains against rational half-planes") {
        Random random(31);
        std::size_t probed = 0, natural = 0, open = 0, at_walls = 0, periodic = 0;
        const std::size_t sets = test::by_size(45, 15);
        for (std::uint64_t number = 0; number < sets; ++number) {
            CAPTURE(number);
            const PlanarSet set = random_set(number, random);
            const std::size_t n = set.points.size() / 2;
            const votess::Diagram diagram(set.points, options_of(set));
            CHECK(diagram.planar());
            for (int q = 0; q < 4; ++q) {
                CAPTURE(q);
                const auto x = random_query(random, set);
                const std::int32_t owner = nearest(set, x);
                CHECK(diagram.locate(x)[0] == owner);
                const double weight = set.weights.empty() ? 0 : std::floor(4 * random.uniform());
                const std::vector<double> weights(set.weights.empty() ? 0 : 1, weight);
                votess::ProbeOptions asked;
                asked.want = everything();
                asked.weights = weights;
                const votess::Tessellation probe = diagram.probe(x, asked);
                CHECK((probe.planar() && probe.probed()));
                const PlanarSet with = with_query(set, x, weight);
                if (owner < 0) {
                    CHECK(probe.status()[0] == votess::CellStatus::outside);
                    CHECK(diagram.natural_neighbors(x).indices.empty());
                    continue;
                }
                // The same row as that of the last seed.
                const auto is_seed = [&](std::size_t i) {
                    return set.points[2 * i] == x[0] && set.points[2 * i + 1] == x[1] && !test::is_duplicate(set, i);
                };
                bool at_seed = false;
                for (std::size_t i = 0; i < n; ++i) at_seed = at_seed || is_seed(i);
                votess::Options options = options_of(with);
                options.want = everything();
                const votess::Tessellation t = votess::tessellate(std::span<const double>(with.points), options);
                if (!at_seed) {
                    const auto row = t.neighbors(n);
                    CHECK(std::ranges::equal(probe.indices(), row));
                    if (!t.shifts().empty())
                        CHECK(std::ranges::equal(
                            probe.shifts(),
                            t.shifts().subspan(2 * static_cast<std::size_t>(t.indptr()[n]), 2 * row.size())));
                }
                const PlanarCell cell = exact_planar_cell(with, n);
                if (at_seed) continue;
                ++probed;
                if (cell.area == 0) {
                    CHECK(probe.status()[0] == votess::CellStatus::empty);
                    continue;
                }
                CHECK(check_probe(probe, cell) == "");
                const bool is_open = cell.lengths.contains(at_infinity);
                bool has_wall = false, meets_itself = false;
                for (const auto& [label, length] : cell.lengths) {
                    has_wall = has_wall || std::get<0>(label) < 0;
                    meets_itself = meets_itself || std::get<0>(label) == static_cast<std::int32_t>(n);
                }
                open += is_open ? 1 : 0;
                at_walls += has_wall && !is_open ? 1 : 0;
                periodic += set.options.cell || set.options.periodic[0] || set.options.periodic[1] ? 1 : 0;
                for (const auto method : {votess::NaturalMethod::sibson, votess::NaturalMethod::laplace}) {
                    votess::NaturalOptions natural_options;
                    natural_options.method = method;
                    natural_options.weights = weights;
                    natural_options.gradients = method == votess::NaturalMethod::sibson;
                    votess::NaturalCoordinates row;
                    const auto error = test::error_of([&] { row = diagram.natural_neighbors(x, natural_options); });
                    CHECK((error == votess::ErrorCode::unsupported) == meets_itself);
                    if (meets_itself || error) continue;
                    if (is_open) {
                        CHECK(row.indices.empty());
                        continue;
                    }
                    if (natural_options.gradients && n > 10) continue;  // the oracle makes all cells
                    const auto expected = exact_weights(set, with, cell, method);
                    REQUIRE(row.indices.size() == expected.size());
                    CHECK(row.gradients.size() == (natural_options.gradients ? 2 * row.indices.size() : 0));
                    std::size_t e = 0;
                    for (const auto& [seed, share] : expected) {
                        CHECK(row.indices[e] == seed);
                        CHECK(std::abs(row.weights[e++] - share) < 1e-12);
                    }
                    ++natural;
                    natural_options.at_walls = false;
                    CHECK(diagram.natural_neighbors(x, natural_options).indices.empty() == has_wall);
                }
            }
        }
        CHECK(probed > sets);
        CHECK(natural > sets);
        CHECK(open > sets / 20);
        CHECK(at_walls > sets / 8);
        CHECK(periodic > sets / 8);
    }

    TEST_CASE("plane: linear fields and their gradients come back off the walls") {
        Random random(32);
        std::vector<double> points, linear, queries;
        for (int i = 0; i < 600; ++i) points.push_back(random.uniform());
        for (std::size_t i = 0; i < points.size(); i += 2) linear.push_back(1 + 2 * points[i] - 3 * points[i + 1]);
        for (int i = 0; i < 400; ++i) queries.push_back(random.uniform());
        votess::Options options;
        options.planar = true;
        for (const bool endless : {false, true}) {
            if (!endless) options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
            if (endless) options.box.reset();
            const votess::Diagram diagram(points, options);
            votess::NaturalOptions natural;
            natural.at_walls = false;
            natural.gradients = true;
            const auto found = diagram.interpolate(linear, 1, queries, natural);
            REQUIRE(found.gradients.size() == queries.size());
            std::size_t inner = 0;
            for (std::size_t q = 0; q < found.values.size(); ++q) {
                if (std::isnan(found.values[q])) continue;
                ++inner;
                CHECK(found.values[q] ==
                      doctest::Approx(1 + 2 * queries[2 * q] - 3 * queries[2 * q + 1]).epsilon(1e-12));
                CHECK(found.gradients[2 * q] == doctest::Approx(2).epsilon(1e-7));
                CHECK(found.gradients[2 * q + 1] == doctest::Approx(-3).epsilon(1e-7));
            }
            CHECK(inner > 120);
        }
    }

    TEST_CASE("plane: grids hold exact averages, and values at centers") {
        Random random(33);
        std::size_t averages = 0;
        for (std::uint64_t number = 0; number < test::by_size(20, 8); ++number) {
            CAPTURE(number);
            PlanarSet set = test::random_planar_set(number);
            set.options.planar = true;
            const std::size_t n = set.points.size() / 2;
            const votess::Diagram diagram(set.points, options_of(set));
            std::vector<double> values;
            for (std::size_t i = 0; i < n; ++i) values.push_back(random.uniform(1, 2));
            const std::size_t nx = 3, ny = 2;
            votess::GridOptions grid{{nx, ny, 1}};
            std::vector<double> mean(nx * ny), near(nx * ny), projected(ny);
            CHECK(diagram.to_grid(values, grid, mean) == 0);
            const votess::Tessellation t = votess::tessellate(std::span<const double>(set.points), options_of(set));
            double total = 0, sum = 0;
            for (std::size_t i = 0; i < n; ++i) total += values[i] * t.volumes()[i];
            const votess::Options& o = set.options;
            const double domain = o.cell ? o.cell->a[0] * o.cell->b[1]
                                         : (o.box->upper[0] - o.box->lower[0]) * (o.box->upper[1] - o.box->lower[1]);
            const double area = domain / static_cast<double>(nx * ny);
            for (const double x : mean) sum += x * area;
            CHECK(sum == doctest::Approx(total).epsilon(1e-11));
            grid.project = 0;
            (void)diagram.to_grid(values, grid, projected);
            const double width = o.cell ? o.cell->a[0] : o.box->upper[0] - o.box->lower[0];
            for (std::size_t j = 0; j < ny; ++j)
                CHECK(projected[j] ==
                      doctest::Approx((mean[j] + mean[ny + j] + mean[2 * ny + j]) * width / nx).epsilon(1e-11));
            grid.project.reset();
            grid.method = votess::GridMethod::nearest;
            (void)diagram.to_grid(values, grid, near);
            for (std::size_t i = 0; i < nx && !o.cell; ++i)
                for (std::size_t j = 0; j < ny; ++j) {
                    const std::array<double, 2> steps{static_cast<double>(i), static_cast<double>(j)}, counts{nx, ny};
                    PlanarSet part = set;
                    std::array<double, 2> center{};
                    for (std::size_t k = 0; k < 2; ++k) {
                        const double lower = o.box->lower[k], side = (o.box->upper[k] - lower) / counts[k];
                        center[k] = lower + (steps[k] + 0.5) * side;
                        votess::Wall wall{{}, lower + (steps[k] + 1) * side};
                        wall.normal[k] = 1;
                        part.options.walls.push_back(wall);
                        wall = {{}, -(lower + steps[k] * side)};
                        wall.normal[k] = -1;
                        part.options.walls.push_back(wall);
                    }
                    const std::int32_t owner = diagram.locate(center)[0];
                    CHECK(near[i * ny + j] == (owner < 0 ? 0 : values[static_cast<std::size_t>(owner)]));
                    if (o.periodic[0] || o.periodic[1]) continue;
                    double average = 0;
                    for (std::size_t s = 0; s < n; ++s)
                        average += values[s] * exact_planar_cell(part, s).area.get_d() / area;
                    CHECK(mean[i * ny + j] == doctest::Approx(average).epsilon(1e-11));
                    ++averages;
                }
        }
        CHECK(averages > 6);
    }

    TEST_CASE("plane: rays pass the cells that hold their pieces") {
        Random random(34);
        std::size_t pieces = 0;
        for (std::uint64_t number = 0; number < test::by_size(40, 16); ++number) {
            CAPTURE(number);
            const PlanarSet set = random_set(number, random);
            const votess::Diagram diagram(set.points, options_of(set));
            for (int r = 0; r < 3; ++r) {
                CAPTURE(r);
                const auto x = random_query(random, set);
                std::array<double, 2> d{random.uniform(-1, 1), random.uniform(-1, 1)};
                if (r == 0) d = {static_cast<double>(random.integer(-1, 1)), 1};
                const double norm = std::hypot(d[0], d[1]), length = random.uniform(0, 2 * size);
                const std::vector<double> lengths{length};
                const auto cells = diagram.trace(x, d, lengths, {.middles = true});
                CHECK((cells.planar && cells.middles.size() == 2 * cells.seeds.size()));
                if (!is_inside(set, x)) {
                    CHECK(cells.seeds.empty());
                    continue;
                }
                double end = length;
                const auto meet = [&](double nx, double ny, double h) {
                    const double speed = (nx * d[0] + ny * d[1]) / norm;
                    if (speed > 0) end = std::min(end, std::max(0.0, (h - nx * x[0] - ny * x[1]) / speed));
                };
                const votess::Options& o = set.options;
                for (std::size_t k = 0; k < 2 && o.box; ++k) {
                    if (o.periodic[k]) continue;
                    meet(k == 0 ? -1 : 0, k == 1 ? -1 : 0, -o.box->lower[k]);
                    meet(k == 0 ? 1 : 0, k == 1 ? 1 : 0, o.box->upper[k]);
                }
                for (const votess::Wall& wall : o.walls) meet(wall.normal[0], wall.normal[1], wall.offset);
                double at = 0;
                for (std::size_t k = 0; k < cells.seeds.size(); ++k) {
                    const double middle = at + 0.5 * cells.lengths[k];
                    at += cells.lengths[k];
                    if (cells.lengths[k] < 1e-9) continue;
                    std::array<double, 2> place{x[0] + middle * d[0] / norm, x[1] + middle * d[1] / norm};
                    if (const auto& periodic = o.cell ? o.cell->periodic : o.periodic; periodic[0] || periodic[1]) {
                        // The oracle knows images near the domain only.
                        const double up = periodic[1] ? std::floor(place[1] / size) : 0;
                        if (o.cell) place[0] -= up * o.cell->b[0];
                        place[1] -= up * size;
                        if (periodic[0]) place[0] -= size * std::floor(place[0] / size);
                    }
                    const auto seed = static_cast<std::size_t>(cells.seeds[k]);
                    const mpq_class least =
                        power_at(set, static_cast<std::size_t>(std::max(0, nearest(set, place))), place);
                    CHECK(mpq_class(power_at(set, seed, place) - least).get_d() < 1e-9);
                    ++pieces;
                }
                CHECK(at == doctest::Approx(end).epsilon(1e-12));
            }
        }
        CHECK(pieces > 60);
    }

    TEST_CASE("plane: what does not fit is refused") {
        votess::Options options;
        options.planar = true;
        const std::vector<double> points{0, 0, 1, 0, 0, 1}, queries{0.25, 0.25};
        const votess::Diagram diagram(points, options);
        CHECK(diagram.size() == 3);
        CHECK(diagram.locate(std::vector<double>{1e6, 1}) == std::vector<std::int32_t>{1});
        const auto refuses = [](const std::string& says, auto call) {
            std::string message;
            CHECK(test::error_of(call, &message) == votess::ErrorCode::invalid_argument);
            CHECK(test::has(message, says));
        };
        refuses("the shape must be (Q,2)", [&] {
            (void)diagram.locate(points.size() == 6 ? std::vector<double>{1, 2, 3} : points);
        });
        refuses("z = 1", [&] {
            votess::Options solid = options;
            solid.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
            (void)votess::Diagram(points, solid);
        });
        std::vector<double> grid(4);
        refuses("shape[2] = 2", [&] { (void)diagram.to_grid(points, {{2, 2, 2}, {}, 2}, grid); });
        refuses("project = 2", [&] {
            votess::GridOptions projected{{2, 2, 1}};
            projected.project = 2;
            (void)diagram.to_grid(std::vector<double>{1, 2, 3}, projected, grid);
        });
        const auto cells = diagram.trace(queries, std::vector<double>{1, 0}, std::vector<double>{2}, {.middles = true});
        const std::vector<double> values{1, 2, 3}, slopes{1, 0, 1, 0, 1, 0};
        // x + 1 in each cell: the seeds have x = 0, 1 and 0.
        CHECK(cells.integrate(values, slopes)[0] == doctest::Approx(2.5 + 2).epsilon(1e-12));
        refuses("give 2 for each value", [&] { (void)cells.integrate(values, values); });
    }
}
