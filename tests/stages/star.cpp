// star: cells found by walking along their edges equal those clipped plane by plane, whenever the walk says that it has
// found them; and it finds nearly all where nearly all are ordinary.
#include "walk/star.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cpu/cell_builder.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/random.hpp"

using namespace votess::cpu;

namespace {

constexpr std::size_t max_seeds = 16384;  // of a stretch

struct ExpectedCell {
    std::vector<std::pair<std::int32_t, double>> faces;  // ids ascending, areas
    int edges = 0, vertices = 0;
    CellGeometry geometry;
};

struct Sorted {
    // scale: none = the engine's.
    explicit Sorted(const test::PointSet& set, double scale = 0) {
        const votess::Job job = votess::make_job(votess::settle({set.points, {}}, test::all_options(set.box)));
        votess::Box box = job.box;
        const double by = scale == 0 ? job.scale : scale;
        for (int k = 0; k < 3; ++k) box.lower[k] *= by, box.upper[k] *= by;
        domain = votess::box_domain(box, {});
        votess::ThreadPool pool(1);
        SeedSorter().sort(std::span<const double>(set.points), scale == 0 ? job.scale : scale, 0, pool, seeds);
        hierarchy.build(seeds, pool);
    }

    [[nodiscard]] std::vector<ExpectedCell> clip() const {
        CellBuilder builder(seeds, hierarchy);
        builder.begin_job(domain);
        CellFaces faces;
        std::vector<double> areas;
        std::vector<ExpectedCell> cells(seeds.size());
        for (std::size_t s = 0; s < seeds.size(); ++s) {
            builder.build(s);
            Cell& cell = builder.rebuild(faces);
            cell.canonical_faces(faces);
            cells[s].geometry = cell.measure(faces, &areas);
            for (std::size_t f = 0; f < faces.size(); ++f)
                cells[s].faces.emplace_back(cell.planes()[faces.planes[f]].id, areas[f]);
            std::ranges::sort(cells[s].faces);
            cells[s].edges = static_cast<int>(faces.edge_count);
            cells[s].vertices = static_cast<int>(faces.vertex_count);
        }
        return cells;
    }

    SortedSeeds seeds;
    Hierarchy hierarchy;
    votess::Domain domain;
};

// One line on what differs, "" when nothing does.
std::string compare(const Star& star, const ExpectedCell& expected) {
    std::vector<std::int32_t> ids(star.faces().begin(), star.faces().end());
    std::ranges::sort(ids);
    if (!std::ranges::equal(ids, expected.faces, {}, {}, [](const auto& face) { return face.first; }))
        return "other faces";
    if (star.edge_count() != expected.edges || star.vertex_count() != expected.vertices)
        return std::to_string(star.vertex_count()) + " vertices instead of " + std::to_string(expected.vertices);
    return "";
}

// The places of ids among all of them, as in a row.
std::vector<std::uint32_t> ranks_of(std::span<const std::int32_t> ids) {
    std::vector<std::uint32_t> ranks;
    for (const std::int32_t id : ids)
        ranks.push_back(
            static_cast<std::uint32_t>(std::ranges::count_if(ids, [id](auto other) { return other < id; })));
    return ranks;
}

// Both sides keep 1e-10.
std::string compare(const CellMeasures& found, const ExpectedCell& expected) {
    const double volume = expected.geometry.volume, size = std::cbrt(volume);
    if (!(std::abs(found.volume - volume) <= 2e-10 * volume)) return "volume " + std::to_string(found.volume / volume);
    const double farthest = expected.geometry.farthest_squared;
    if (!(std::abs(found.farthest_squared - farthest) <= 1e-7 * farthest)) return "farthest vertex";
    double surface = 0, longest = size;
    for (const auto& [id, area] : expected.faces) surface += area;
    for (std::size_t f = 0; f < expected.faces.size(); ++f)
        if (!(std::abs(found.areas[f] - expected.faces[f].second) <= 2e-10 * surface))
            return "area of " + std::to_string(expected.faces[f].first);
    longest = std::max(longest, surface / size);
    for (int k = 0; k < 3; ++k)
        if (!(std::abs(found.centroid[k] - expected.geometry.centroid[k]) <= 4e-10 * longest)) return "centroid";
    return "";
}

// The walk's cell and the same one clipped have the same digits.
std::string compare(const CellMeasures& found, const CellMeasures& clipped, std::size_t faces) {
    if (found.volume != clipped.volume) return "volume in its last digits";
    if (found.centroid != clipped.centroid) return "centroid in its last digits";
    if (found.farthest_squared != clipped.farthest_squared) return "farthest vertex in its last digits";
    if (!std::equal(found.areas.begin(), found.areas.begin() + static_cast<std::ptrdiff_t>(faces),
                    clipped.areas.begin()))
        return "area in its last digits";
    return "";
}

struct Rates {
    double built = 0, measured = 0;
};

// Builds the chosen cells in stretches of so many of them, which begin in front of the first as in CpuClipper.
Rates check(const Sorted& sorted, const std::vector<ExpectedCell>& cells, std::span<const std::size_t> chosen,
            std::size_t length, const Kernels& kernels, Star::Keep keep = Star::Keep::corners) {
    const auto star = make_star(kernels.name, sorted.seeds, sorted.hierarchy);
    star->begin_job(sorted.domain);
    std::size_t built = 0, measured = 0;
    CellMeasures found, again;
    CellShape clipped_shape;
    ShapeReader reader;
    CellBuilder builder(sorted.seeds, sorted.hierarchy, kernels);
    builder.begin_job(sorted.domain);
    CellFaces faces;
    std::vector<std::int32_t> ids;
    for (std::size_t k = 0, last = 0; k < chosen.size(); ++k) {
        if (k % length == 0 || chosen[k] >= last) {
            const std::size_t first = chosen[k] / Star::alignment * Star::alignment;
            last = std::min(chosen[std::min(chosen.size(), k + length) - 1] + 1, first + max_seeds);
            star->begin(first, last, keep);
        }
        if (!star->build(chosen[k])) continue;
        ++built;
        INFO("sorted seed " << chosen[k]);
        REQUIRE(compare(*star, cells[chosen[k]]) == "");
        if (keep == Star::Keep::nothing) continue;
        CellShape* shape = star->shape(ranks_of(star->faces()));
        REQUIRE(shape != nullptr);
        if (!star_kernels(kernels.name).measure(*shape, found)) continue;
        ++measured;
        REQUIRE(compare(found, cells[chosen[k]]) == "");
        if (chosen[k] % 8 != 0) continue;
        Cell& cell = builder.build(chosen[k]);
        cell.canonical_faces(faces);
        ids.clear();
        for (const std::int32_t plane : faces.planes) ids.push_back(cell.planes()[static_cast<std::size_t>(plane)].id);
        REQUIRE(reader.read(cell, faces, ranks_of(ids), false, clipped_shape));
        REQUIRE(star_kernels(kernels.name).measure(clipped_shape, again));
        REQUIRE(compare(found, again, ids.size()) == "");
    }
    const auto count = static_cast<double>(chosen.size());
    return {static_cast<double>(built) / count, static_cast<double>(measured) / count};
}

std::vector<std::size_t> all_of(const Sorted& sorted) {
    std::vector<std::size_t> all(sorted.seeds.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

// The least rates of all sets of instructions.
Rates check_all(const test::PointSet& set, std::size_t length = 2048) {
    CAPTURE(set.name);
    const Sorted sorted(set);
    const auto cells = sorted.clip();
    Rates least{1, 1};
    for (const Kernels* kernels : supported_kernels()) {
        INFO(std::string(kernels->name));
        const Rates rates = check(sorted, cells, all_of(sorted), length, *kernels);
        least.built = std::min(least.built, rates.built);
        least.measured = std::min(least.measured, rates.measured);
    }
    return least;
}

test::PointSet slab(std::size_t n, double thickness, std::uint64_t seed) {
    test::PointSet set = test::uniform(n, seed);
    for (std::size_t i = 2; i < set.points.size(); i += 3) set.points[i] = 0.5 + thickness * (set.points[i] - 0.5);
    set.name = "slab";
    return set;
}

// A hub amid `n` seeds that are all its neighbors, and random seeds around them.
test::PointSet hub(std::size_t n, std::uint64_t seed) {
    test::PointSet set = test::on_sphere_and_center(n + 1, seed);
    test::Random random(seed);
    while (set.size() < 4 * n) {
        std::array<double, 3> p;
        double square = 0;
        for (auto& x : p) x = random.uniform(-8, 8), square += x * x;
        if (square > 16) set.points.insert(set.points.end(), p.begin(), p.end());
    }
    set.name = "hub";
    set.box.reset();
    return set;
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("star: every family equals the exact clip") {
        for (const test::PointSet& set : test::families(test::by_size(900, 150), 11)) check_all(set);
        for (const double thickness : {1e-2, 1e-4, 1e-9}) check_all(slab(test::by_size(1500, 250), thickness, 12));
        for (const double amplitude : {1e-15, 1e-12, 1e-6, 1e-3}) check_all(test::jittered(9, amplitude, 13));
        check_all(test::cocircular(25, 6));
        for (int squared_radius : {9, 41}) check_all(test::cospherical_and_center(squared_radius));
        check_all(test::cospherical_and_center(101));
    }

    TEST_CASE("star: most ordinary cells are built") {
        const Rates uniform = check_all(test::uniform(test::by_size(6000, 3000), 14));
        CHECK(uniform.built >= 0.999);
        CHECK(uniform.measured >= 0.995);
        const Rates clustered = check_all(test::clustered(test::by_size(6000, 3000), 15));
        CHECK(clustered.built >= 0.99);
        for (const test::PointSet& set : {test::cubic(14), test::bcc(10), test::fcc(10), test::jittered(14, 0.2, 16)}) {
            CAPTURE(set.name);
            const Rates rates = check_all(set);
            CHECK(rates.built >= 0.99);
            CHECK(rates.measured >= 0.99);
        }
    }

    TEST_CASE("star: stretches of any length") {
        for (const test::PointSet& set : {test::uniform(400, 17), test::cubic(7), test::fcc(5), hub(50, 18)}) {
            CAPTURE(set.name);
            const Sorted sorted(set);
            const auto cells = sorted.clip();
            const auto all = all_of(sorted);
            test::Random random(19);
            std::vector<std::size_t> some;
            for (const std::size_t s : all)
                if (random.chance(0.3)) some.push_back(s);
            for (const Kernels* kernels : supported_kernels()) {
                INFO(std::string(kernels->name));
                // All short ones, then every fifth.
                for (std::size_t length = 1; length <= 50; length += length < 16 ? test::by_size(1, 15) : 5) {
                    CAPTURE(length);
                    check(sorted, cells, all, length, *kernels,
                          length % 2 == 0 ? Star::Keep::corners : Star::Keep::nothing);
                    check(sorted, cells, some, length, *kernels,
                          length % 3 == 0 ? Star::Keep::places : Star::Keep::nothing);
                }
                check(sorted, cells, some, some.size(), *kernels);
            }
        }
        const Sorted more(test::uniform(max_seeds + 500, 20));
        const auto cells = more.clip();
        for (const Kernels* kernels : supported_kernels())
            for (const std::size_t length : {max_seeds, max_seeds - 1, std::size_t{1000}})
                CHECK(check(more, cells, all_of(more), length, *kernels).built >= 0.999);
    }

    TEST_CASE("star: a hub's cell is built or left to others, and its neighbors are right") {
        for (const std::size_t n : {20, 40, 60, 62, 64, 66, 100, 130, 300}) {
            CAPTURE(n);
            const test::PointSet set = hub(n, 21);
            const Sorted sorted(set);
            const auto cells = sorted.clip();
            const auto center = static_cast<std::size_t>(
                std::ranges::find(sorted.seeds.input, static_cast<std::int32_t>(n)) - sorted.seeds.input.begin());
            REQUIRE(cells[center].faces.size() == n);
            for (const Kernels* kernels : supported_kernels()) {
                INFO(std::string(kernels->name));
                check(sorted, cells, all_of(sorted), max_seeds, *kernels);
                // Alone, and with others in front that hand it vertices.
                for (const std::size_t begin : {center, center / 2, std::size_t{0}}) {
                    const auto star = make_star(kernels->name, sorted.seeds, sorted.hierarchy);
                    star->begin_job(sorted.domain);
                    star->begin(begin / Star::alignment * Star::alignment, sorted.seeds.size(), Star::Keep::nothing);
                    for (std::size_t s = begin; s < center; ++s) (void)star->build(s);
                    const bool built = star->build(center);
                    if (n > Star::max_planes) CHECK_FALSE(built);
                    if (n <= 40) CHECK(built);
                    for (std::size_t s = center + 1; s < sorted.seeds.size(); ++s)
                        if (star->build(s)) REQUIRE(compare(*star, cells[s]) == "");
                }
            }
            const auto t = test::run(set);
            CHECK(t.neighbors(n).size() == n);
            CHECK(test::check_invariants(t, set.points) == "");
        }
    }

    TEST_CASE("star: tiny and huge coordinates, with the engine's scale and without") {
        const std::vector<test::PointSet> sets{test::uniform(300, 22), test::fcc(4), test::jittered(6, 1e-13, 23)};
        for (const test::PointSet& set : sets) {
            CAPTURE(set.name);
            test::PointSet base = set;
            base.box = test::run(set).box();
            const auto cells = Sorted(base).clip();
            const double usual = check_all(base).built;
            if (set.name != sets.back().name) CHECK(usual >= 0.99);
            for (const int exponent : {-1000, -400, -300, -200, -60, -20, 20, 60, 200, 300, 400, 1000}) {
                CAPTURE(exponent);
                const double factor = std::ldexp(1.0, exponent);
                CHECK(check_all(test::scaled(base, factor)).built >= 0.99 * usual);
                const Sorted unscaled(base, factor);
                for (const Kernels* kernels : supported_kernels()) {
                    INFO(std::string(kernels->name));
                    const Rates rates = check(unscaled, cells, all_of(unscaled), 2048, *kernels, Star::Keep::nothing);
                    if (std::abs(exponent) <= 60) CHECK(rates.built >= 0.99 * usual);
                }
            }
        }
    }
}
