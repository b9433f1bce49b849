// Diagram::probe against tessellating the seeds with the query among them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>
#include <votess/diagram.hpp>

#include "cases/query/query_cases.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

namespace {

using test::Coordinates;

votess::Want everything() {
    votess::Want want;
    want.centroids = want.counts = want.areas = want.normals = want.surfaces = want.radii = want.faces = true;
    return want;
}

template <class Values>
auto row(const Values& values, const votess::Tessellation& t, std::size_t i, std::size_t each = 1) {
    const auto begin = static_cast<std::size_t>(t.indptr()[i]), end = static_cast<std::size_t>(t.indptr()[i + 1]);
    return values.empty() ? values : values.subspan(each * begin, each * (end - begin));
}

bool equal(auto a, auto b) {
    return std::ranges::equal(a, b);
}

bool near(std::span<const double> a, std::span<const double> b, double error) {
    return std::ranges::equal(a, b, [&](double x, double y) { return std::abs(x - y) <= error; });
}

// The corners of each polygon, in order, relative to those of a cell.
Coordinates corners(const votess::Tessellation& t, std::size_t i) {
    Coordinates all;
    for (auto f = t.indptr()[i]; f < t.indptr()[i + 1]; ++f) {
        const auto face = static_cast<std::size_t>(f);
        for (auto k = t.face_offsets()[face]; k < t.face_offsets()[face + 1]; ++k) {
            const auto vertex = static_cast<std::size_t>(t.face_vertices()[static_cast<std::size_t>(k)]);
            for (std::size_t c = 0; c < 3; ++c) all.push_back(t.vertices()[3 * vertex + c]);
        }
    }
    return all;
}

// "" when cell a of one result is cell b of another, where only the geometry is rounded.
std::string difference(const votess::Tessellation& s, std::size_t a, const votess::Tessellation& t, std::size_t b) {
    const bool of_seed = s.status()[a] == votess::CellStatus::duplicate;  // which has the cell
    if (s.status()[a] != t.status()[b] && !(of_seed && t.status()[b] == votess::CellStatus::certified)) return "status";
    if (!equal(s.neighbors(a), t.neighbors(b))) return "neighbors";
    if (!equal(row(s.shifts(), s, a, 3), row(t.shifts(), t, b, 3))) return "shifts";
    if (s.face_counts()[a] != t.face_counts()[b] || s.edge_counts()[a] != t.edge_counts()[b] ||
        s.vertex_counts()[a] != t.vertex_counts()[b])
        return "counts";
    const double volume = t.volumes()[b], surface = t.surface_areas()[b], length = t.security_radii()[b];
    const auto close = [](double x, double y, double error) { return std::abs(x - y) <= error; };
    if (!close(s.volumes()[a], volume, 1e-9 * surface * length)) return "volume";
    if (!close(s.surface_areas()[a], surface, 1e-9 * surface)) return "surface";
    if (!close(s.security_radii()[a], length, 1e-9 * length)) return "radius";
    if (!near(row(s.face_areas(), s, a), row(t.face_areas(), t, b), 1e-9 * surface)) return "areas";
    if (!near(row(s.face_normals(), s, a, 3), row(t.face_normals(), t, b, 3), 1e-9)) return "normals";
    if (!near(corners(s, a), corners(t, b), 1e-8 * length + 1e-14)) return "polygons";
    if (volume > 1e-6 * surface * length &&
        !near(s.centroids().subspan(3 * a, 3), t.centroids().subspan(3 * b, 3), 1e-8 * length))
        return "centroid";
    return "";
}

// The cells of the seeds and of query q, which is the last one.
votess::Tessellation with_query(const test::QueryCase& c, const Coordinates& queries, std::size_t q,
                                votess::Options options, double weight = 0) {
    Coordinates points = c.points;
    points.insert(points.end(), &queries[3 * q], &queries[3 * q] + 3);
    std::vector<double> weights = c.weights;
    if (!weights.empty()) weights.push_back(weight);
    options.weights = weights;
    return votess::tessellate(points, options);
}

// Each query for itself: what the seeds and it come to.
void check_probes(const test::QueryCase& c, const Coordinates& queries, const std::vector<double>& weights) {
    votess::Options options = c.options;
    options.weights = c.weights;
    const votess::Diagram diagram(c.points, options);
    votess::ProbeOptions of_probes;
    of_probes.want = everything();
    of_probes.weights = weights;
    const auto probes = diagram.probe(queries, of_probes);
    REQUIRE(probes.size() == queries.size() / 3);
    options.want = everything();
    options.outside = votess::Outside::drop;
    const std::size_t n = c.points.size() / 3;
    for (std::size_t q = 0; q < probes.size(); ++q) {
        CAPTURE(q);
        const auto t = with_query(c, queries, q, options, weights.empty() ? 0 : weights[q]);
        const std::int32_t same = t.duplicate_of().empty() ? -1 : t.duplicate_of()[n];
        CHECK(difference(probes, q, t, same < 0 ? n : static_cast<std::size_t>(same)) == "");
        CHECK((probes.duplicate_of().empty() ? -1 : probes.duplicate_of()[q]) == same);
    }
}

}  // namespace

TEST_SUITE("probe") {
    TEST_CASE("probe: random domains and queries are what tessellating with them gives") {
        test::Random random(21);
        for (std::size_t set = 0; set < test::by_size(300, 40); ++set) {
            CAPTURE(set);
            test::QueryCase c = test::random_query_case(random, set % 2 == 0);
            const auto& o = c.options;
            const bool repeats = o.cell ? o.cell->periodic[0] && o.cell->periodic[1] && o.cell->periodic[2]
                                        : o.periodic[0] && o.periodic[1] && o.periodic[2];
            Coordinates queries;
            std::vector<double> weights;
            for (int q = 0; q < 8; ++q) {
                const auto x = test::random_query(random, c, repeats);
                queries.insert(queries.end(), x.begin(), x.end());
                if (!c.weights.empty())
                    weights.push_back(set % 2 == 0 ? static_cast<double>(random.below(4)) / 16
                                                   : random.uniform(-0.1, 0.3));
            }
            check_probes(c, queries, weights);
        }
    }

    // Enough seeds that the walk finds most cells, with windows for several probes.
    TEST_CASE("probe: many seeds in every domain") {
        const std::size_t n = test::by_size(1500, 300);
        test::Random random(22);
        for (int domain = 0; domain < 7; ++domain) {
            CAPTURE(domain);
            test::QueryCase c;
            c.options.threads = 1;
            c.options.box = test::unit_box();
            c.points = (domain == 1 ? test::clustered(n, 5) : test::uniform(n, 6)).points;
            if (domain == 2) c.options.periodic = {true, true, true};
            if (domain == 3) c.options.walls = {{{1, 2, 0.7}, 2}};
            if (domain == 4) {
                c.options.box.reset();
                c.options.cell = votess::TriclinicBox{{}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.2, 1}};
            }
            if (domain == 6) c.options.periodic = {false, true, false};
            std::vector<double> weights;
            Coordinates queries;
            for (int q = 0; q < 12; ++q) {
                // Some near each other, some next to a seed.
                const std::size_t i = random.below(c.points.size() / 3);
                for (std::size_t k = 0; k < 3; ++k)
                    queries.push_back(q < 4   ? 0.4 + 0.02 * random.uniform()
                                      : q < 8 ? random.uniform()
                                              : c.points[3 * i + k] + 1e-9 * random.uniform());
                weights.push_back(domain >= 5 ? random.uniform(0, 0.002) : 0);
            }
            if (domain >= 5)
                for (std::size_t i = 0; i < c.points.size() / 3; ++i) c.weights.push_back(random.uniform(0, 0.003));
            if (domain < 5) weights.clear();
            c.options.outside = votess::Outside::drop;
            check_probes(c, queries, weights);
        }
    }

    // Cells so flat that seeds are moved into a reduced one, thin and far boxes, queries next to seeds and far outside.
    TEST_CASE("probe: extreme domains") {
        test::Random random(23);
        for (std::size_t set = 0; set < test::by_size(120, 24); ++set) {
            CAPTURE(set);
            test::QueryCase c;
            c.options.threads = 1;
            votess::TriclinicBox cell{{}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
            const auto kind = set % 6;
            if (kind == 0) cell.b = {3.4, 1, 0}, cell.c = {-2.7, 1.8, 1};
            if (kind == 1) cell.b = {0.5, 0.05, 0}, cell.c = {0.25, 0.125, 0.5};
            if (kind == 2) cell.b = {0, 1e-3, 0};
            if (kind == 3) cell.a = {0x1p-10, 0, 0}, cell.b = {0, 0x1p-10, 0}, cell.c = {0, 0, 0x1p-10};
            if (kind == 3) cell.origin = {1e8, -1e8, 3e7};
            if (kind == 4) cell.b = {2.5, 1, 0}, cell.periodic = {true, true, false};
            if (kind == 5) cell.c = {30, -20, 1}, cell.periodic = {true, false, true};
            c.options.cell = cell;
            const auto at = [&](double a, double b, double d, Coordinates& to) {
                for (std::size_t k = 0; k < 3; ++k)
                    to.push_back(cell.origin[k] + a * cell.a[k] + b * cell.b[k] + d * cell.c[k]);
            };
            const std::size_t n = 1 + random.below(40);
            for (std::size_t i = 0; i < n; ++i) at(random.uniform(), random.uniform(), random.uniform(), c.points);
            if (set % 4 == 3)
                for (std::size_t i = 0; i < n; ++i) c.weights.push_back(1e-7 * random.uniform());
            Coordinates queries;
            for (int q = 0; q < 6; ++q) {
                const auto far = [&](std::size_t j) {
                    return cell.periodic[j] ? random.uniform(-3, 4) : random.uniform(0, 1);
                };
                if (q < 3) {
                    at(far(0), far(1), far(2), queries);
                    continue;
                }
                const std::size_t i = random.below(n);
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = c.points[3 * i + k];
                    queries.push_back(q == 3 ? x : std::nextafter(x, random.below(2) == 0 ? -1e9 : 1e9));
                }
            }
            c.options.outside = votess::Outside::drop;
            check_probes(c, queries, {});
        }
    }

    // Queries have more digits than the seeds, and may lie farther out, so that vertices lie farther too.
    TEST_CASE("probe: domains with some or all sides at infinity") {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        test::Random random(24);
        std::size_t open = 0, closed = 0;
        for (std::size_t set = 0; set < test::by_size(60, 16); ++set) {
            CAPTURE(set);
            test::QueryCase c;
            c.options.threads = 1;
            c.options.box = votess::Box{{-1, -1, -1}, {3, 3, 3}};
            votess::Options large = c.options;
            for (std::size_t k = 0; k < 3; ++k) {
                const bool all = set % 3 == 0;
                if (all || random.chance(0.5)) c.options.box->lower[k] = -infinity, large.box->lower[k] = -0x1p70;
                if (all || random.chance(0.5)) c.options.box->upper[k] = infinity, large.box->upper[k] = 0x1p70;
            }
            for (std::size_t i = 3 * (4 + random.below(12)); i > 0; --i)
                c.points.push_back(static_cast<double>(random.below(17)) / 8);
            if (set % 4 == 1)
                for (std::size_t i = 0; i < c.points.size() / 3; ++i) c.weights.push_back(random.uniform(0, 0.25));
            Coordinates queries;
            for (int q = 0; q < 4; ++q)
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = random.uniform(0, 2);
                    const bool far = q == 3 && std::isinf(c.options.box->upper[k]);
                    // Nearly in the plane of three seeds.
                    const double flat = q == 2 ? (c.points[k] + c.points[3 + k] + c.points[6 + k]) / 3 + 1e-12 * x : x;
                    queries.push_back(far ? 1e5 * x : flat);
                }
            votess::Options options = c.options;
            options.weights = large.weights = c.weights;
            const votess::Diagram diagram(c.points, options), finite(c.points, large);
            CHECK(diagram.locate(queries) == finite.locate(queries));
            votess::ProbeOptions of_probes;
            of_probes.want = everything();
            const auto probes = diagram.probe(queries, of_probes);
            const auto natural = diagram.natural_neighbors(queries), in_box = finite.natural_neighbors(queries);
            options.want = everything();
            for (std::size_t q = 0; q < probes.size(); ++q) {
                CAPTURE(q);
                const auto t = with_query(c, queries, q, options);
                const std::size_t n = c.points.size() / 3;
                REQUIRE(probes.status()[q] == t.status()[n]);
                REQUIRE(equal(probes.neighbors(q), t.neighbors(n)));
                REQUIRE(std::isinf(probes.volumes()[q]) == std::isinf(t.volumes()[n]));
                const auto row_of = [q](const votess::NaturalCoordinates& of) {
                    const auto begin = static_cast<std::size_t>(of.indptr[q]),
                               count = static_cast<std::size_t>(of.indptr[q + 1]) - begin;
                    return std::pair{std::span(of.indices).subspan(begin, count),
                                     std::span(of.weights).subspan(begin, count)};
                };
                if (std::isinf(t.volumes()[n])) {
                    ++open;
                    CHECK(row_of(natural).first.empty());
                    continue;
                }
                ++closed;
                CHECK(difference(probes, q, t, n) == "");
                CHECK(equal(row_of(natural).first, row_of(in_box).first));
                CHECK(near(row_of(natural).second, row_of(in_box).second, 1e-11));
            }
        }
        CHECK(open > 12);
        CHECK(closed > 12);
    }

    // By probes in a box that ends far away, and by runs with the query as a seed. Queries lie on seeds' planes or
    // lines, beside them, and far out.
    TEST_CASE("probe: flat seeds in a domain without end") {
        constexpr double infinity = std::numeric_limits<double>::infinity(), far = 0x1p160;
        test::Random random(27);
        for (std::size_t set = 0; set < test::by_size(56, 14); ++set) {
            CAPTURE(set);
            test::QueryCase c;
            c.options.threads = 1;
            c.options.box = votess::Box{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
            votess::Options large = c.options;
            large.box = votess::Box{{-far, -far, -far}, {far, far, far}};
            if (set % 7 == 0) c.options.box->lower[1] = large.box->lower[1] = -64;
            const auto flat = [&](double u, double v) {
                const std::array<std::array<double, 3>, 7> kinds{
                    {{u, v, 0.25}, {u, v, u}, {u, v, -u - v}, {u, 0, 0}, {u, u, u}, {u, -2 * u, 3 * u}, {u, u, 7}}};
                return kinds[set % 7];
            };
            const auto number = [&] { return static_cast<double>(random.below(set % 2 == 0 ? 8 : 1024)) / 8; };
            Coordinates queries;
            const auto add = [](Coordinates& to, const std::array<double, 3>& x) {
                to.insert(to.end(), x.begin(), x.end());
            };
            const auto place = [&](double times, double beside) {
                const double u = times * number() + beside;  // in this order for each compiler
                return flat(u, times * number() + beside);
            };
            for (std::size_t i = 2 + random.below(30); i > 0; --i) add(c.points, place(1, 0));
            if (set % 4 == 1)
                for (std::size_t i = 0; i < c.points.size() / 3; ++i) c.weights.push_back(random.uniform(0, 0.25));
            for (int q = 0; q < 3; ++q) add(queries, place(1, 0.0625));  // not on a seed
            add(queries, place(1e4, 0.0625));
            add(queries, {number(), number() + 0.5, number() + 0.0625});
            votess::Options options = c.options;
            options.weights = large.weights = c.weights;
            const votess::Diagram diagram(c.points, options), finite(c.points, large);
            votess::ProbeOptions of_probes;
            of_probes.list_walls = true;
            const auto in_box = finite.probe(queries, of_probes);
            of_probes.want = everything();
            const auto probes = diagram.probe(queries, of_probes);
            CHECK(diagram.locate(queries) == finite.locate(queries));
            CHECK(diagram.natural_neighbors(queries).indices.empty());
            options.want = everything();
            options.list_walls = true;
            for (std::size_t q = 0; q < probes.size(); ++q) {
                CAPTURE(q);
                REQUIRE(probes.status()[q] == in_box.status()[q]);
                std::vector<std::int32_t> seeds, expected;
                for (const std::int32_t id : probes.neighbors(q))
                    if (id >= 0) seeds.push_back(id);
                for (const std::int32_t id : in_box.neighbors(q))
                    if (id >= 0) expected.push_back(id);
                REQUIRE(seeds == expected);
                const auto t = with_query(c, queries, q, options);
                if (t.status().back() != votess::CellStatus::certified) continue;
                REQUIRE(equal(probes.neighbors(q), t.neighbors(t.size() - 1)));
                REQUIRE(std::isinf(probes.volumes()[q]));
                REQUIRE(probes.face_counts()[q] == t.face_counts().back());
                REQUIRE(probes.edge_counts()[q] == t.edge_counts().back());
                REQUIRE(probes.vertex_counts()[q] == t.vertex_counts().back());
            }
        }
        // The cells are those of a plane: nearly none needs long integers, which all needed between far ends. The seeds
        // have few digits, so that tilted planes and lines hold them.
        const std::size_t n = test::by_size(4000, 1000);
        for (const int kind : {0, 1, 2}) {
            CAPTURE(kind);
            Coordinates points, queries;
            for (std::size_t i = 0; i < n + 100; ++i) {
                const double u = std::ldexp(static_cast<double>(random.below(1 << 20)), -20);
                const double v = std::ldexp(static_cast<double>(random.below(1 << 20)), -20);
                const std::array<std::array<double, 3>, 3> kinds{{{u, v, 0}, {u, v, u + 2 * v}, {u, 2 * u, 3 * u}}};
                (i < n ? points : queries)
                    .insert((i < n ? points : queries).end(), kinds[kind].begin(), kinds[kind].end());
            }
            const auto probes = votess::Diagram(points).probe(queries, {});
            CHECK(static_cast<std::size_t>(std::ranges::count(probes.volumes(), infinity)) == 100);
            CHECK(probes.stats().exact_cells < 20);
        }
    }

    TEST_CASE("probe: no seeds, several threads, and what is refused") {
        votess::Options options;
        options.box = test::unit_box();
        votess::ProbeOptions all;
        all.want = everything();
        const auto whole = votess::Diagram(Coordinates{}, options).probe(Coordinates{0.5, 0.25, 0.5, 2, 0, 0}, all);
        CHECK(whole.volumes()[0] == doctest::Approx(1));
        CHECK(whole.neighbors(0).size() == 6);
        CHECK(whole.status()[1] == votess::CellStatus::outside);
        CHECK(votess::Diagram().probe(Coordinates{}).size() == 0);

        const auto set = test::uniform(test::by_size(3000, 500), 3), queries = test::uniform(5000, 4);
        options.threads = 1;
        const auto one = votess::Diagram(set.points, options).probe(queries.points, all);
        options.threads = 3;
        const auto three = votess::Diagram(set.points, options).probe(queries.points, all);
        CHECK(std::ranges::equal(one.indices(), three.indices()));
        CHECK(std::ranges::equal(one.indptr(), three.indptr()));

        const std::vector<double> weights(5000, 0.0);
        votess::ProbeOptions weighted;
        weighted.weights = weights;
        CHECK_THROWS_AS((void)votess::Diagram(set.points, options).probe(queries.points, weighted), votess::Error);
    }

    TEST_CASE("probe: what asks for a whole diagram refuses its cells") {
        const auto points = test::uniform(20, 1).points;
        votess::Options options;
        options.box = test::unit_box();
        options.periodic = {true, true, true};
        const votess::Diagram diagram(points, options);
        votess::ProbeOptions of_probes;
        of_probes.want = everything();
        const auto probes = diagram.probe(points, of_probes);
        CHECK(probes.probed());
        CHECK_FALSE(votess::tessellate(points, options).probed());
        const auto refuses = [](const std::string& says, auto function) {
            try {
                (void)function();
                FAIL("nothing was refused");
            } catch (const votess::Error& error) {
                CHECK(error.code() == votess::ErrorCode::invalid_argument);
                CHECK(std::string(error.what()).find(says) != std::string::npos);
            }
        };
        refuses("delaunay(): cells of probes do not form a diagram", [&] { return votess::delaunay(probes); });
        refuses("verify(): cells of probes do not form a diagram", [&] { return votess::verify(probes, points); });
        CHECK(votess::wrapped_points(probes, points) ==
              votess::wrapped_points(votess::tessellate(points, options), points));
        refuses("the seeds have none", [&] {
            const std::vector<double> weights(20);
            return diagram.probe(points, {.want = {}, .weights = weights, .radii = {}});
        });
    }
}
