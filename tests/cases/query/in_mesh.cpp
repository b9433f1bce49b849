// Diagrams in a closed mesh, against rational crossings of lines with its triangles, seeds by brute force, walls of
// convex meshes, and tessellations that hold the query.
#include <doctest/doctest.h>
#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>
#include <vector>
#include <votess/diagram.hpp>
#include <votess/pieces.hpp>

#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"
#include "support/text.hpp"
#include "support/vectors.hpp"

namespace {

using test::Coordinates;
using test::cross;
using test::dot;
using test::minus;
using test::Random;
using test::rational;
using test::Solid;
using votess::Diagram;
using votess::Options;
using votess::Tessellation;
using Vector = test::RationalVector;

struct Crossing {
    mpq_class time;
    int sign;
};
// Returns the crossings of a whole line with a mesh; nothing if it meets an edge or lies in a triangle's plane.
std::optional<std::vector<Crossing>> crossings(const Solid& solid, const Vector& origin, const Vector& direction) {
    std::vector<Crossing> found;
    for (std::size_t t = 0; t < solid.triangles.size(); t += 3) {
        std::array<Vector, 3> x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = minus(rational(&solid.vertices[3 * static_cast<std::size_t>(solid.triangles[t + k])]), origin);
        const Vector n = cross(minus(x[1], x[0]), minus(x[2], x[0]));
        std::array<int, 3> side;
        for (std::size_t k = 0; k < 3; ++k) side[k] = sgn(dot(direction, cross(x[k], x[(k + 1) % 3])));
        const auto [least, most] = std::ranges::minmax(side);
        if (least < 0 && most > 0) continue;
        if (least == 0 || most == 0) return {};
        found.push_back({dot(n, x[0]) / dot(n, direction), sgn(dot(n, direction))});
    }
    return found;
}

bool on_surface(const Solid& solid, const Vector& place) {
    for (std::size_t t = 0; t < solid.triangles.size(); t += 3) {
        std::array<Vector, 3> x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = minus(rational(&solid.vertices[3 * static_cast<std::size_t>(solid.triangles[t + k])]), place);
        const Vector n = cross(minus(x[1], x[0]), minus(x[2], x[0]));
        if (dot(n, x[0]) != 0) continue;
        bool within = true;
        for (std::size_t k = 0; k < 3; ++k) within = within && sgn(dot(n, cross(x[k], x[(k + 1) % 3]))) >= 0;
        if (within) return true;
    }
    return false;
}

// Returns whether a place lies in a mesh, whose surface is inside.
bool is_inside(const Solid& solid, const Vector& place) {
    if (on_surface(solid, place)) return true;
    for (int turn = 1;; ++turn) {
        const auto found = crossings(solid, place, {mpq_class(1), mpq_class(turn, 1009), mpq_class(7 * turn, 30011)});
        if (!found) continue;
        int winding = 0;
        for (const Crossing& crossing : *found) winding += crossing.time > 0 ? crossing.sign : 0;
        return winding != 0;
    }
}

struct Set {
    Solid solid;
    Coordinates points;
    std::vector<double> weights;
    Options options;
    std::array<Vector, 3> periods{};  // 0 where nothing repeats
    bool repeats = false;

    [[nodiscard]] Options with_mesh() const {
        Options with = options;
        with.mesh = solid.mesh();
        with.weights = weights;
        return with;
    }
    // Calls use(x) with the images of a place around another.
    template <class Use>
    void for_images(const Vector& place, const Vector& around, int reach, Use use) const {
        Vector near = place;
        for (std::size_t j = 3; j-- > 0 && repeats;) {  // periods are a triangular matrix
            const mpq_class away = (around[j] - near[j]) / periods[j][j];
            const mpq_class times(static_cast<long>(std::lround(away.get_d())));
            for (std::size_t k = 0; k < 3; ++k) near[k] += times * periods[j][k];
        }
        const int most = repeats ? reach : 0;
        for (int a = -most; a <= most; ++a)
            for (int b = -most; b <= most; ++b)
                for (int c = -most; c <= most; ++c) {
                    Vector x = near;
                    for (std::size_t k = 0; k < 3; ++k)
                        x[k] += a * periods[0][k] + b * periods[1][k] + c * periods[2][k];
                    use(x);
                }
    }
    // Returns whether a place, or a segment from it, may lie in the bounds of the mesh.
    [[nodiscard]] bool may_meet(const Vector& place, const double* way = nullptr, double times = 0) const {
        for (std::size_t k = 0; k < 3; ++k) {
            const double from = place[k].get_d(), to = from + (way == nullptr ? 0 : way[k] * times);
            double least = 1e9, most = -1e9;
            for (std::size_t i = k; i < solid.vertices.size(); i += 3)
                least = std::min(least, solid.vertices[i]), most = std::max(most, solid.vertices[i]);
            if (std::max(from, to) < least - 1e-9 || std::min(from, to) > most + 1e-9) return false;
        }
        return true;
    }
    [[nodiscard]] Vector middle_of_mesh() const { return {mpq_class(0.5), mpq_class(0.5), mpq_class(0.25)}; }
    [[nodiscard]] bool holds(const Vector& place) const {
        bool any = false;
        for_images(place, middle_of_mesh(), 3,
                   [&](const Vector& x) { any = any || (may_meet(x) && is_inside(solid, x)); });
        return any;
    }
    // Returns the lowest of the seeds with the least power.
    [[nodiscard]] std::int32_t nearest(const Vector& place) const {
        std::int32_t best = -1;
        mpq_class least;
        for (std::size_t i = 0; 3 * i < points.size(); ++i)
            for_images(rational(&points[3 * i]), place, 2, [&](const Vector& seed) {
                const Vector d = minus(seed, place);
                const mpq_class power = dot(d, d) - mpq_class(weights.empty() ? 0.0 : weights[i]);
                if (best >= 0 && power >= least) return;
                best = static_cast<std::int32_t>(i);
                least = power;
            });
        return best;
    }
};

// Solids from 0 to at most 3 or around 0: with holes, cavities and parts that touch or cross.
Solid any_solid(Random& random) {
    switch (random.below(6)) {
        case 0: {
            std::vector<bool> filled(27);
            for (std::size_t i = 0; i < filled.size(); ++i) filled[i] = random.chance(0.4);
            filled[13] = true;
            return test::cubes({3, 3, 3}, filled);
        }
        case 1:
            return test::torus(static_cast<int>(random.integer(3, 8)), static_cast<int>(random.integer(3, 5)));
        case 2:
            for (;;) {
                std::array<std::array<double, 3>, 4> corners;
                for (auto& corner : corners)
                    for (double& x : corner) x = static_cast<double>(random.integer(-4, 4)) / 2;
                const Vector a = minus(rational(corners[1].data()), rational(corners[0].data())),
                             b = minus(rational(corners[2].data()), rational(corners[0].data())),
                             c = minus(rational(corners[3].data()), rational(corners[0].data()));
                if (dot(a, cross(b, c)) != 0) return test::tetrahedron(corners);
            }
        case 3:
            return test::joined(test::joined(test::cuboid(0, 2), test::cuboid(0.5, 1.5).reversed()),
                                test::cuboid(0.75, 1.25));
        case 4:
            return test::joined(test::cuboid(0, 1), test::cuboid({1, 0, 0}, {2, 1, 1}));  // glued
        default:
            return test::joined(test::cuboid(0, 1), test::cuboid(0.5, 1.5));
    }
}

Set any_set(std::size_t number, bool weights) {
    Random random(number + 71);
    Set set;
    set.solid = any_solid(random);
    set.options.device = "cpu";
    set.options.threads = 1;
    double lower = -2.5, upper = 3.5;
    const std::uint64_t kind = random.below(4);
    if (kind == 1) set.options.box = votess::Box{{-2.5, -2.5, -2.5}, {3.5, 3.5, 3.5}};
    if (kind >= 2) {
        // The box touches the mesh.
        std::array<double, 3> least{8, 8, 8}, most{-8, -8, -8};
        for (std::size_t i = 0; i < set.solid.vertices.size(); ++i) {
            least[i % 3] = std::min(least[i % 3], set.solid.vertices[i]);
            most[i % 3] = std::max(most[i % 3], set.solid.vertices[i]);
        }
        set.repeats = true;
        const double more = static_cast<double>(random.below(2));
        for (std::size_t k = 0; k < 3; ++k) most[k] += more;
        lower = -1, upper = 2;
        if (kind == 2) {
            set.options.box = votess::Box{least, most};
            set.options.periodic = {true, true, true};
            for (std::size_t k = 0; k < 3; ++k) set.periods[k][k] = mpq_class(most[k]) - mpq_class(least[k]);
        } else {
            votess::TriclinicBox cell;
            for (double& x : least) x -= 2;
            for (double& x : most) x += 2;
            cell.origin = least;
            cell.a = {most[0] - least[0], 0, 0};
            cell.b = {0.5, most[1] - least[1], 0};
            cell.c = {0.25, -0.5, most[2] - least[2]};
            cell.periodic = {true, true, true};
            set.options.cell = cell;
            set.periods = {rational(cell.a.data()), rational(cell.b.data()), rational(cell.c.data())};
        }
    }
    const auto count = static_cast<std::size_t>(random.integer(1, 12));
    const bool ties = random.chance(0.4);
    for (std::size_t i = 0; i < 3 * count; ++i) {
        const double x = random.uniform(lower, upper);
        set.points.push_back(ties ? std::round(4 * x) / 4 : x);
    }
    for (std::size_t i = 0; i < count && weights; ++i) set.weights.push_back(std::round(random.uniform(0, 16)) / 16);
    return set;
}

Coordinates any_queries(const Set& set, std::size_t count, Random& random) {
    Coordinates queries;
    for (std::size_t q = 0; q < count; ++q) {
        const std::size_t kind = random.below(4);
        const std::size_t v = random.below(set.solid.vertices.size() / 3), i = random.below(set.points.size() / 3);
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = random.uniform(-2.25, 3.25);
            queries.push_back(kind == 0   ? x
                              : kind == 1 ? std::round(4 * x) / 4
                              : kind == 2 ? set.solid.vertices[3 * v + k]
                                          : set.points[3 * i + k]);
        }
    }
    return queries;
}

std::string check_locate(const Set& set, std::uint64_t number) {
    Random random(number);
    const Coordinates queries = any_queries(set, 12, random);
    const std::vector<std::int32_t> found = Diagram(set.points, set.with_mesh()).locate(queries);
    for (std::size_t q = 0; q < found.size(); ++q) {
        const Vector x = rational(&queries[3 * q]);
        const std::int32_t expected = set.holds(x) ? set.nearest(x) : -1;
        // Of equal seeds the lowest has the cell, also where a later one is heavier.
        if (found[q] == expected) continue;
        return test::text("query ", q, " at ", queries[3 * q], " ", queries[3 * q + 1], " ", queries[3 * q + 2],
                          " has seed ", found[q], " instead of ", expected);
    }
    return "";
}

// The pieces of a ray have its length inside, and lie there in the cells of their seeds.
std::string check_trace(const Set& set, std::uint64_t number) {
    Random random(number);
    const Diagram diagram(set.points, set.with_mesh());
    const Coordinates origins = any_queries(set, 8, random);
    Coordinates directions, lengths;
    for (std::size_t r = 0; r < 8; ++r) {
        const bool ties = random.chance(0.3);
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = random.uniform(-1, 1);
            directions.push_back(ties ? std::round(2 * x) / 2 : x);
        }
        if (directions[3 * r] == 0 && directions[3 * r + 1] == 0) directions[3 * r + 2] = 1;
        lengths.push_back(random.chance(0.5) || set.repeats ? random.uniform(0, 2) : 12);
    }
    votess::TraceOptions with_middles;
    with_middles.middles = true;
    const votess::RayCells cells = diagram.trace(origins, directions, lengths, with_middles);
    for (std::size_t r = 0; r < 8; ++r) {
        const double* const d = &directions[3 * r];
        const double speed = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const mpq_class end = mpq_class(lengths[r]) / mpq_class(speed);
        std::vector<Crossing> all;
        bool generic = true;
        set.for_images(rational(&origins[3 * r]), set.middle_of_mesh(), 5, [&](const Vector& x) {
            if (!generic || !set.may_meet(x, d, lengths[r] / speed)) return;
            const auto found = crossings(set.solid, x, rational(d));
            generic = found.has_value();
            if (found) all.insert(all.end(), found->begin(), found->end());
        });
        if (!generic) continue;
        std::ranges::sort(all, {}, &Crossing::time);
        int winding = 0;
        for (const Crossing& crossing : all) winding += crossing.time > 0 ? crossing.sign : 0;
        mpq_class inside = 0, last = 0;
        for (const Crossing& crossing : all) {
            if (crossing.time <= 0) continue;
            const mpq_class time = std::min(crossing.time, end);
            if (winding != 0) inside += time - last;
            last = time;
            winding -= crossing.sign;
        }
        double sum = 0;
        for (auto k = cells.offsets[r]; k < cells.offsets[r + 1]; ++k)
            sum += cells.lengths[static_cast<std::size_t>(k)];
        const double expected = inside.get_d() * speed;
        if (!(std::abs(sum - expected) <= 1e-12 * lengths[r]))
            return test::text("ray ", r, " has the length ", sum, " instead of ", expected);
        for (auto k = static_cast<std::size_t>(cells.offsets[r]); k < static_cast<std::size_t>(cells.offsets[r + 1]);
             ++k) {
            if (cells.lengths[k] < 1e-9) continue;
            Vector middle;  // of an image
            for (std::size_t j = 0; j < 3; ++j)
                middle[j] = mpq_class(set.points[3 * static_cast<std::size_t>(cells.seeds[k]) + j]) +
                            mpq_class(cells.middles[3 * k + j]);
            // To rounding, in case the piece lies in a plane between cells.
            const std::int32_t near = set.nearest(middle), seed = cells.seeds[k];
            if (near != seed && set.weights.empty() && set.repeats == false) {
                const auto square = [&](std::int32_t i) {
                    const Vector d = minus(rational(&set.points[3 * static_cast<std::size_t>(i)]), middle);
                    return dot(d, d).get_d();
                };
                if (square(seed) - square(near) > 1e-12)
                    return test::text("piece ", k, " of ray ", r, " has seed ", seed);
            }
            if (set.options.cell || set.repeats) continue;
            if (!set.holds(middle)) return test::text("piece ", k, " of ray ", r, " lies outside");
        }
    }
    return "";
}

bool near(double a, double b, double error) {
    return a == b || std::abs(a - b) <= error || (std::isnan(a) && std::isnan(b));
}

// Cells of probes are those of a tessellation with the query as its last seed.
std::string check_probe(const Set& set, std::uint64_t number) {
    Random random(number);
    Coordinates queries = any_queries(set, 6, random);
    if (!set.options.box && !set.options.cell)  // the last one may be so far away that its cell is not near the mesh
        for (std::size_t k = 15; k < 18; ++k) queries[k] *= 4;
    std::vector<double> weights;
    if (!set.weights.empty())
        for (std::size_t q = 0; q < 6; ++q) weights.push_back(std::round(random.uniform(0, 16)) / 16);
    votess::ProbeOptions options;
    options.want.areas = options.want.centroids = options.want.surfaces = options.want.normals = true;
    options.weights = weights;
    const Tessellation probes = Diagram(set.points, set.with_mesh()).probe(queries, options);
    const std::size_t n = set.points.size() / 3;
    for (std::size_t q = 0; q < 6; ++q) {
        Coordinates all = set.points;
        all.insert(all.end(), &queries[3 * q], &queries[3 * q] + 3);
        Options with = set.with_mesh();
        std::vector<double> all_weights = set.weights;
        if (!weights.empty()) all_weights.push_back(weights[q]);
        with.weights = all_weights;
        with.want = options.want;
        const Tessellation t = votess::tessellate(all, with);
        std::size_t row = n;
        if (t.status()[n] == votess::CellStatus::duplicate) {
            if (!weights.empty()) continue;  // the heavier one has a cell
            row = static_cast<std::size_t>(t.duplicate_of()[n]);
            if (probes.status()[q] != votess::CellStatus::duplicate || probes.duplicate_of()[q] != t.duplicate_of()[n])
                return test::text("query ", q, " is not a duplicate");
        }
        const auto fail = [&](const char* what) {
            return test::text("query ", q, " at ", queries[3 * q], " ", queries[3 * q + 1], " ", queries[3 * q + 2],
                              " has other ", what);
        };
        if (!std::ranges::equal(probes.neighbors(q), t.neighbors(row))) return fail("neighbors");
        if (row == n && probes.status()[q] != t.status()[n]) return fail("statuses");
        if (!near(probes.volumes()[q], t.volumes()[row], 1e-10)) return fail("volumes");
        if (!near(probes.surface_areas()[q], t.surface_areas()[row], 1e-10)) return fail("surfaces");
        if (!near(probes.mesh_areas()[q], t.mesh_areas()[row], 1e-10)) return fail("areas of the mesh");
        const auto here = static_cast<std::size_t>(probes.indptr()[q]),
                   there = static_cast<std::size_t>(t.indptr()[row]);
        for (std::size_t k = 0; k < t.neighbors(row).size(); ++k) {
            if (!near(probes.face_areas()[here + k], t.face_areas()[there + k], 1e-10)) return fail("areas");
            for (std::size_t j = 0; j < 3; ++j) {
                if (!near(probes.face_normals()[3 * (here + k) + j], t.face_normals()[3 * (there + k) + j], 1e-10))
                    return fail("normals");
                if (set.repeats && probes.shifts()[3 * (here + k) + j] != t.shifts()[3 * (there + k) + j])
                    return fail("shifts");
            }
        }
        for (std::size_t k = 0; k < 3; ++k)
            if (!near(probes.centroids()[3 * q + k] * t.volumes()[row], t.centroids()[3 * row + k] * t.volumes()[row],
                      1e-9))
                return fail("centroids");
    }
    double of_pieces = 0, of_probes = 0;
    for (const double volume : votess::pieces(probes).volumes) of_pieces += volume;
    for (const double volume : probes.volumes()) of_probes += volume;
    return near(of_pieces, of_probes, 1e-10) ? "" : "pieces of probes have other volumes";
}

// Answers inside are those of the domain around the mesh. Outside there are none.
std::string check_natural(const Set& set, std::uint64_t number) {
    Random random(number);
    const Coordinates queries = any_queries(set, 12, random);
    Options around = set.options;
    around.weights = set.weights;
    const Diagram in_mesh(set.points, set.with_mesh()), whole(set.points, around);
    const std::vector<std::int32_t> seeds = in_mesh.locate(queries);
    std::vector<double> values(2 * set.points.size() / 3);
    for (double& value : values) value = random.uniform();
    votess::NaturalCoordinates some, all;
    try {
        all = whole.natural_neighbors(queries);
        some = in_mesh.natural_neighbors(queries);
    } catch (const votess::Error& error) {
        return error.code() == votess::ErrorCode::unsupported ? "" : error.what();  // a cell that meets its image
    }
    const votess::Interpolated a = in_mesh.interpolate(values, 2, queries), b = whole.interpolate(values, 2, queries);
    for (std::size_t q = 0; q < seeds.size(); ++q) {
        const std::int64_t first = some.indptr[q], count = some.indptr[q + 1] - first, from = all.indptr[q];
        if (count != (seeds[q] < 0 ? 0 : all.indptr[q + 1] - from)) return test::text("the row of query ", q);
        for (std::int64_t k = 0; k < count; ++k)
            if (some.indices[static_cast<std::size_t>(first + k)] != all.indices[static_cast<std::size_t>(from + k)] ||
                !near(some.weights[static_cast<std::size_t>(first + k)],
                      all.weights[static_cast<std::size_t>(from + k)], 1e-12))
                return test::text("coordinates of query ", q);
        for (std::size_t c = 2 * q; c < 2 * q + 2; ++c)
            if (seeds[q] < 0 ? !std::isnan(a.values[c]) : !near(a.values[c], b.values[c], 1e-12))
                return test::text("values at query ", q);
    }
    return "";
}

// VOTESS_TEST_SETS: the number of sets.
void check_sets(std::string (*check)(const Set&, std::uint64_t), std::size_t count) {
    const char* const given = std::getenv("VOTESS_TEST_SETS");
    const std::size_t sets = given != nullptr ? std::strtoull(given, nullptr, 10) : test::by_size(count, 8);
    for (std::size_t number = 0; number < sets; ++number) {
        CAPTURE(number);
        CHECK(check(any_set(number, number % 3 == 0), number) == "");
    }
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("in mesh: locate() finds the nearest seed inside, and none outside") {
        check_sets(check_locate, 30);
    }

    TEST_CASE("in mesh: rays have their lengths inside") {
        check_sets(check_trace, 30);
    }

    TEST_CASE("in mesh: probes have the cells of added seeds") {
        check_sets(check_probe, 40);
        for (std::size_t number = 0; number < 20; ++number) {  // one seed, so that cells have no vertices
            Set set = any_set(number, false);
            set.points.resize(3);
            CAPTURE(number);
            CHECK(check_probe(set, number) == "");
        }
    }

    TEST_CASE("in mesh: natural neighbors are those of the domain around it") {
        check_sets(check_natural, 40);
    }

    TEST_CASE("in mesh: a mesh that fills a periodic box changes no ray") {
        Random random(5);
        Coordinates points(60), origins(60), directions(60);
        for (double& x : points) x = random.uniform();
        for (double& x : origins) x = random.uniform(-1, 2);
        for (double& x : directions) x = random.uniform(-1, 1);
        const std::vector<double> lengths(20, 5.0);
        Options options;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.periodic = {true, true, true};
        const votess::RayCells whole = Diagram(points, options).trace(origins, directions, lengths);
        const Solid solid = test::cuboid(0, 1);
        options.mesh = solid.mesh();
        const votess::RayCells cut = Diagram(points, options).trace(origins, directions, lengths);
        CHECK(cut.offsets == whole.offsets);
        CHECK(cut.seeds == whole.seeds);
        CHECK(cut.lengths == whole.lengths);
    }

    TEST_CASE("in mesh: a tetrahedron has the answers of its walls") {
        Random random(6);
        const Solid solid = test::tetrahedron({{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}}});
        Coordinates points(90), queries(300);
        for (double& x : points) x = random.uniform(-0.5, 2);
        for (double& x : queries) x = random.uniform(0, 1);
        std::vector<double> values(60);
        for (double& value : values) value = random.uniform();
        Options options;
        options.box = votess::Box{{-1, -1, -1}, {3, 3, 3}};
        Options by_walls = options;
        by_walls.walls = {{{-1, 0, 0}, 0}, {{0, -1, 0}, 0}, {{0, 0, -1}, 0}, {{1, 1, 1}, 2}};
        by_walls.outside = votess::Outside::keep;
        options.mesh = solid.mesh();
        const Diagram in_mesh(points, options), in_walls(points, by_walls);
        const std::vector<std::int32_t> seeds = in_walls.locate(queries);
        CHECK(in_mesh.locate(queries) == seeds);
        Coordinates origins, directions;
        for (std::size_t q = 0; q < seeds.size(); ++q)
            for (std::size_t k = 0; k < 3 && seeds[q] >= 0; ++k) {
                origins.push_back(queries[3 * q + k]);
                directions.push_back(random.uniform(-1, 1));
            }
        const std::vector<double> lengths(origins.size() / 3, std::numeric_limits<double>::infinity());
        const votess::RayCells a = in_mesh.trace(origins, directions, lengths),
                               b = in_walls.trace(origins, directions, lengths);
        CHECK(a.seeds == b.seeds);
        for (std::size_t k = 0; k < std::min(a.lengths.size(), b.lengths.size()); ++k)
            CHECK(a.lengths[k] == doctest::Approx(b.lengths[k]).epsilon(1e-12));
        for (const auto method : {votess::GridMethod::mean, votess::GridMethod::nearest}) {
            const votess::GridOptions grid{{7, 5, 6}, method, 2};
            std::vector<double> x(420), y(420);
            in_mesh.to_grid(values, grid, x);
            in_walls.to_grid(values, grid, y);
            for (std::size_t k = 0; k < x.size(); ++k) CHECK(std::abs(x[k] - y[k]) < 1e-13);
        }
        std::vector<double> x(420);
        in_mesh.to_grid(values, {{7, 5, 6}, votess::GridMethod::sibson, 2}, x);
        const std::vector<double> ones(60, 1.0);
        in_mesh.to_grid(ones, {{7, 5, 6}, votess::GridMethod::sibson, 2}, x);
        std::vector<double> nearest(420);
        in_mesh.to_grid(ones, {{7, 5, 6}, votess::GridMethod::nearest, 2}, nearest);
        for (std::size_t k = 0; k < x.size(); ++k) CHECK(x[k] == doctest::Approx(nearest[k]));
    }

    TEST_CASE("in mesh: the grid of a mean holds the solid") {
        Random random(7);
        std::vector<bool> filled(27);
        for (std::size_t i = 0; i < filled.size(); ++i) filled[i] = random.chance(0.5);
        const Solid solid = test::cubes({3, 3, 3}, filled);
        Coordinates points(45);
        for (double& x : points) x = random.uniform(0, 3);
        Options options;
        options.box = votess::Box{{0, 0, 0}, {3, 3, 3}};
        options.periodic = {true, true, true};
        options.mesh = solid.mesh();
        const Diagram diagram(points, options);
        std::vector<double> grid(27);
        diagram.to_grid(std::vector<double>(15, 1.0), {{3, 3, 3}, votess::GridMethod::mean}, grid);
        for (std::size_t k = 0; k < grid.size(); ++k) CHECK(std::abs(grid[k] - (filled[k] ? 1 : 0)) < 1e-12);
        CHECK_THROWS_WITH_AS(diagram.to_grid(std::vector<double>(15, 1.0), {{3, 3, 3}, votess::GridMethod::dtfe}, grid),
                             doctest::Contains("beyond a mesh"), votess::Error);
    }

    // Rounded vertices of so thin a piece say little about its volume.
    TEST_CASE("in mesh: the grid of a mean holds a thin sheet") {
        const std::vector<std::int32_t> triangles{0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                                  1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
        for (const double thickness : {1e-3, 1e-6, 1e-9, 1e-11, 1e-13})
            for (const double offset : {0.0, 0.77}) {
                CAPTURE(thickness);
                Coordinates vertices{0, 0, 0, 1, 0, 0.3, 1, 1, 0.7, 0, 1, 0.4};
                for (double& x : vertices) x += offset;
                for (std::size_t k = 0; k < 12; ++k) vertices.push_back(vertices[k] + (k % 3 == 2 ? thickness : 0));
                votess::Options options;
                options.mesh = votess::TriangleMesh{vertices, triangles};
                const Coordinates points{0.3 + offset, 0.5 + offset, 0.5 + offset,
                                         0.8 + offset, 0.4 + offset, 0.1 + offset};
                const double volume = votess::tessellate(points, options).stats().volume_sum;
                const votess::Diagram diagram(points, options);
                std::vector<double> field(64);
                diagram.to_grid(std::vector<double>(2, 1.0), {{4, 4, 4}, votess::GridMethod::mean}, field);
                const votess::Box box = votess::tessellate(points, options).box();
                double cell = 1, sum = 0;
                for (std::size_t k = 0; k < 3; ++k) cell *= (box.upper[k] - box.lower[k]) / 4;
                for (const double x : field) sum += x * cell;
                CHECK(std::abs(sum / volume - 1) < 1e-11);
            }
    }

    TEST_CASE("in mesh: refusals") {
        const Solid solid = test::cuboid(0, 1);
        const Coordinates points{0.5, 0.5, 0.5, 0.25, 0.5, 0.5};
        Options options;
        options.mesh = solid.mesh();
        const Diagram diagram(points, options);
        votess::ProbeOptions faces;
        faces.want.faces = true;
        CHECK_THROWS_WITH_AS((void)diagram.probe(points, faces), doctest::Contains("use pieces()"), votess::Error);
        options.box = votess::Box{{0, 0, 0}, {2, 2, 2}};
        CHECK_THROWS_WITH_AS(Diagram(points, options), doctest::Contains("strictly inside"), votess::Error);
        options.box.reset();
        options.walls = {{{1, 0, 0}, 2}};
        CHECK_THROWS_WITH_AS(Diagram(points, options), doctest::Contains("replaces Options::walls"), votess::Error);
        CHECK(Diagram(Coordinates{},
                      [&] {
                          Options empty;
                          empty.mesh = solid.mesh();
                          return empty;
                      }())
                  .locate(points) == std::vector<std::int32_t>{-1, -1});
    }
}
