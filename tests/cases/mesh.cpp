// The option `mesh`: cells cut by a closed triangle mesh. oracle/cells_in_mesh.cpp proves single cells.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>
#include <votess/pieces.hpp>

#include "support/check.hpp"
#include "support/random.hpp"
#include "support/solids.hpp"
#include "support/text.hpp"

namespace {

using test::Coordinates;
using test::Solid;
using votess::Options;
using votess::Tessellation;

Options options_in(const Solid& solid) {
    Options options;
    options.device = "cpu";
    options.threads = 1;
    options.want.centroids = options.want.areas = options.want.surfaces = true;
    options.mesh = solid.mesh();
    return options;
}

double sum(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
}

Coordinates random_seeds(std::size_t n, double lower, double upper, std::uint64_t number) {
    test::Random random(number);
    Coordinates points(3 * n);
    for (double& x : points) x = random.uniform(lower, upper);
    return points;
}

Coordinates lattice(double lower, double upper, double step) {
    Coordinates points;
    for (double x = lower; x <= upper; x += step)
        for (double y = lower; y <= upper; y += step)
            for (double z = lower; z <= upper; z += step) points.insert(points.end(), {x, y, z});
    return points;
}

// Volumes and areas of the mesh sum to those of the mesh. Rows are symmetric, with one area and one cell on each side.
std::string check_sums(const Tessellation& t, const Solid& solid, double error = 1e-13) {
    if (!(std::abs(sum(t.volumes()) / solid.volume() - 1) <= error))
        return test::text("volumes sum to ", sum(t.volumes()), " of ", solid.volume());
    if (!(std::abs(t.stats().volume_sum / t.stats().box_volume - 1) <= error)) return "the sum in stats";
    if (!(std::abs(sum(t.mesh_areas()) / solid.area() - 1) <= error))
        return test::text("areas sum to ", sum(t.mesh_areas()), " of ", solid.area());
    for (std::size_t i = 0; i < t.size(); ++i) {
        const auto row = t.neighbors(i);
        double surface = t.mesh_areas()[i];
        const bool empty = t.status()[i] != votess::CellStatus::certified;
        if (empty && (!row.empty() || t.volumes()[i] != 0)) return test::text("cell ", i, " is not empty");
        for (std::size_t k = 0; k < row.size(); ++k) {
            const double area = t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k];
            const auto j = static_cast<std::size_t>(row[k]);
            const auto back = t.neighbors(j);
            const auto at = std::ranges::find(back, static_cast<std::int32_t>(i));
            if (at == back.end()) return test::text("cell ", i, " lists ", j, ", which does not list it back");
            if (t.face_areas()[static_cast<std::size_t>(t.indptr()[j] + (at - back.begin()))] != area || !(area > 0))
                return test::text("cells ", i, " and ", j, " differ on the area of their face");
            surface += area;
        }
        if (!(std::abs(t.surface_areas()[i] - surface) <= error * surface)) return test::text("the surface of ", i);
    }
    return "";
}

// "" if two results have equal rows, and equal measures within rounding.
std::string difference(const Tessellation& a, const Tessellation& b, double error = 1e-12) {
    if (!std::ranges::equal(a.indptr(), b.indptr()) || !std::ranges::equal(a.indices(), b.indices())) return "rows";
    if (!std::ranges::equal(a.status(), b.status())) return "statuses";
    const auto far = [&](auto array) {
        const auto x = (a.*array)(), y = (b.*array)();
        for (std::size_t i = 0; i < std::max(x.size(), y.size()); ++i)
            if (x.size() != y.size() || !(std::abs(x[i] - y[i]) <= error || (std::isnan(x[i]) && std::isnan(y[i]))))
                return true;
        return false;
    };
    if (far(&Tessellation::volumes)) return "volumes";
    if (far(&Tessellation::face_areas)) return "areas";
    for (std::size_t i = 0; i < a.centroids().size(); ++i)
        if (std::abs(a.centroids()[i] - b.centroids()[i]) * a.volumes()[i / 3] > error) return "centroids";
    return far(&Tessellation::surface_areas) ? "surfaces" : "";
}

// The triangles of a piece.
struct View {
    View(const votess::Pieces& pieces, std::size_t p)
        : first(static_cast<std::size_t>(pieces.triangle_offsets[p])),
          triangles(std::span(pieces.triangles)
                        .subspan(3 * first, 3 * (static_cast<std::size_t>(pieces.triangle_offsets[p + 1]) - first))),
          vertices(
              std::span(pieces.vertices)
                  .subspan(3 * static_cast<std::size_t>(pieces.vertex_offsets[p]),
                           3 * static_cast<std::size_t>(pieces.vertex_offsets[p + 1] - pieces.vertex_offsets[p]))) {}
    [[nodiscard]] Solid solid() const {
        return {{vertices.begin(), vertices.end()}, {triangles.begin(), triangles.end()}};
    }

    std::size_t first;
    std::span<const std::int32_t> triangles;
    std::span<const double> vertices;
};

// "" if the edges of a piece cancel, and Euler's formula holds: V - E + F is even, and at most 2 for each surface.
std::string check_closed(const View& piece, int& handles) {
    const std::size_t count = piece.vertices.size() / 3;
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    std::vector<std::size_t> set(count), used(count);
    std::iota(set.begin(), set.end(), std::size_t{0});
    const auto root = [&](std::size_t v) {
        while (set[v] != v) v = set[v] = set[set[v]];
        return v;
    };
    for (std::size_t i = 0; i < piece.triangles.size(); ++i) {
        const std::int32_t from = piece.triangles[i], to = piece.triangles[i % 3 == 2 ? i - 2 : i + 1];
        if (from == to) return "an edge begins and ends at one vertex";
        ++edges[{from, to}];
        --edges[{to, from}];
        set[root(static_cast<std::size_t>(from))] = root(static_cast<std::size_t>(to));
        used[static_cast<std::size_t>(from)] = 1;
    }
    for (const auto& [edge, sum] : edges)
        if (sum != 0) return test::text("the edge ", edge.first, " ", edge.second, " is open");
    if (std::ranges::count(used, std::size_t{0}) != 0) return "a vertex of no triangle";
    int surfaces = 0;
    for (std::size_t v = 0; v < count; ++v) surfaces += root(v) == v ? 1 : 0;
    const int faces = static_cast<int>(piece.triangles.size() / 3);
    const int euler = static_cast<int>(count) - 3 * faces / 2 + faces;
    handles += (2 * surfaces - euler) / 2;
    return faces % 2 == 0 && euler % 2 == 0 && euler <= 2 * surfaces ? "" : test::text("V - E + F = ", euler);
}

// "" if the pieces are closed, and the volumes are those of their triangles and sum to those of the cells.
std::string check_pieces(const Tessellation& t, const votess::Pieces& pieces, int* handles = nullptr) {
    int found = 0;
    const double whole = t.stats().box_volume;
    for (std::size_t i = 0; i < t.size(); ++i) {
        double volume = 0;
        for (auto k = pieces.indptr[i]; k < pieces.indptr[i + 1]; ++k) {
            const auto p = static_cast<std::size_t>(k);
            const View piece(pieces, p);
            if (const std::string failure = check_closed(piece, found); !failure.empty())
                return test::text("piece ", p, ": ", failure);
            if (!(std::abs(piece.solid().volume() - pieces.volumes[p]) <= 1e-12 * whole))
                return test::text("piece ", p, " has the volume ", piece.solid().volume(), ", not ", pieces.volumes[p]);
            if (k > pieces.indptr[i] && pieces.volumes[p] > pieces.volumes[p - 1]) return "a larger piece comes later";
            volume += pieces.volumes[p];
        }
        if (!(std::abs(volume - t.volumes()[i]) <= 1e-12 * std::max(std::abs(volume), 1e-3 * whole)))
            return test::text("cell ", i, " has the volume ", t.volumes()[i], ", its pieces ", volume);
    }
    if (handles != nullptr) *handles = found;
    return "";
}

// "" if the areas of the pieces on each plane and on the surface are those of the cells.
std::string check_sources(const Tessellation& t, const votess::Pieces& pieces, const Solid& solid) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        std::map<std::int32_t, double> areas;
        double surface = 0;
        for (auto k = pieces.indptr[i]; k < pieces.indptr[i + 1]; ++k) {
            const View piece(pieces, static_cast<std::size_t>(k));
            for (std::size_t f = 0; 3 * f < piece.triangles.size(); ++f) {
                const auto corners = piece.triangles.subspan(3 * f, 3);
                const double area = Solid{piece.solid().vertices, {corners.begin(), corners.end()}}.area();
                const std::int32_t source = pieces.sources[piece.first + f];
                if (pieces.on_surface[piece.first + f] == 0) {
                    areas[source] += area;
                    continue;
                }
                surface += area;
                // The part of a triangle with one of its corners has no volume.
                Solid flat{piece.solid().vertices, {corners.begin(), corners.end()}};
                for (std::size_t corner = 0; corner < 3; ++corner) {
                    const auto v =
                        static_cast<std::size_t>(solid.triangles[3 * static_cast<std::size_t>(source) + corner]);
                    std::array<std::array<double, 3>, 4> x;
                    std::copy_n(&solid.vertices[3 * v], 3, x[3].begin());
                    for (std::size_t c = 0; c < 3; ++c)
                        std::copy_n(&flat.vertices[3 * static_cast<std::size_t>(corners[c])], 3, x[c].begin());
                    if (std::abs(test::tetrahedron(x).volume()) > 1e-12) return test::text("the source of a triangle");
                }
            }
        }
        if (std::abs(surface - t.mesh_areas()[i]) > 1e-11) return test::text("the surface of cell ", i);
        const auto row = t.neighbors(i);
        for (std::size_t k = 0; k < row.size(); ++k) {
            const double area = t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k];
            if (std::abs(areas[row[k]] - area) > 1e-11) return test::text("the face of cells ", i, " and ", row[k]);
            areas.erase(row[k]);
        }
        for (const auto& [j, area] : areas)
            if (area > 1e-11) return test::text("cells ", i, " and ", j, " are not neighbors");
    }
    return "";
}

std::vector<std::int64_t> piece_counts(const votess::Pieces& pieces) {
    std::vector<std::int64_t> counts;
    for (std::size_t i = 0; i + 1 < pieces.indptr.size(); ++i)
        counts.push_back(pieces.indptr[i + 1] - pieces.indptr[i]);
    return counts;
}

// Returns the number of parts of a grid of cubes that share faces.
int connected_cubes(const std::array<int, 3>& count, std::vector<bool> filled) {
    int parts = 0;
    for (std::size_t start = 0; start < filled.size(); ++start) {
        if (!filled[start]) continue;
        ++parts;
        std::vector<std::size_t> pending{start};
        filled[start] = false;
        while (!pending.empty()) {
            const auto at = static_cast<int>(pending.back());
            pending.pop_back();
            const std::array<int, 3> x{at / (count[1] * count[2]), at / count[2] % count[1], at % count[2]};
            for (std::size_t k = 0; k < 3; ++k)
                for (const int step : {-1, 1}) {
                    auto y = x;
                    y[k] += step;
                    if (y[k] < 0 || y[k] >= count[k]) continue;
                    const auto next = static_cast<std::size_t>((y[0] * count[1] + y[1]) * count[2] + y[2]);
                    if (filled[next]) pending.push_back(next);
                    filled[next] = false;
                }
        }
    }
    return parts;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("mesh: volumes and areas sum to the mesh's") {
        const Solid unit = test::cuboid(0, 1), ring = test::torus(24, 12);
        const Solid glued = test::joined(unit, test::cuboid({1, 0, 0}, {2, 1, 1}));
        const Solid shells = test::joined(unit, test::cuboid(0.25, 0.75).reversed());
        const Solid nested = test::joined(shells, test::cuboid(0.375, 0.625));
        const Solid crossing = test::joined(unit, test::cuboid(0.5, 1.5));
        for (const auto& [name, solid] : {std::pair{"cube", unit},
                                          {"torus", ring},
                                          {"glued", glued},
                                          {"shells", shells},
                                          {"nested", nested},
                                          {"crossing", crossing}}) {
            CAPTURE(std::string(name));
            for (const std::size_t n : {std::size_t{1}, std::size_t{7}, test::by_size(300, 60)}) {
                Coordinates points = random_seeds(n, -0.5, 1.5, n);
                Options options = options_in(solid);
                CHECK(check_sums(votess::tessellate(points, options), solid) == "");
                const std::vector<double> weights = random_seeds(n, 0, 0.01, n + 1);
                options.weights = std::span(weights).first(n);
                CHECK(check_sums(votess::tessellate(points, options), solid) == "");
                for (double& x : points) x = std::round(x * 16) / 16;  // ties with the mesh, and equal seeds
                CHECK(check_sums(votess::tessellate(points, options), solid) == "");
            }
            // Seeds and bisectors in planes of the mesh.
            for (const double shift : {0.0, 0.125, 0.0625})
                CHECK(check_sums(votess::tessellate(lattice(-0.25 + shift, 1.25 + shift, 0.25), options_in(solid)),
                                 solid) == "");
        }
    }

    TEST_CASE("mesh: rounding of sums does not grow with the number of triangles") {
        const Solid ring = test::torus(300, 100);
        const Coordinates points{0.9, 0, 0, -0.9, 0.1, 0};
        const Tessellation t = votess::tessellate(points, options_in(ring));
        CHECK(std::abs(t.stats().volume_sum / t.stats().box_volume - 1) < 5e-16);
    }

    // VOTESS_TEST_SETS: the number of sets.
    TEST_CASE("mesh: sums where sides lie within rounding of bisectors") {
        using test::NearBisector;
        const char* const given = std::getenv("VOTESS_TEST_SETS");
        const std::size_t sets = given != nullptr ? std::strtoull(given, nullptr, 10) : test::by_size(300, 40);
        test::Random random(61);
        for (std::size_t number = 0; number < sets; ++number) {
            CAPTURE(number);
            const NearBisector set = test::near_bisector(static_cast<NearBisector::Kind>(number % 4), random);
            Options options = options_in(set.solid);
            options.threads = 1;
            const Tessellation t = votess::tessellate(set.points, options);
            CHECK(check_sums(t, set.solid, 1e-12) == "");
        }
    }

    // Rows of a run of all seeds and of a run of some hold the same faces, however small.
    TEST_CASE("mesh: the same small faces for some cells") {
        using test::NearBisector;
        test::Random random(62);
        for (std::size_t number = 0; number < test::by_size(60, 12); ++number) {
            CAPTURE(number);
            const NearBisector set = test::near_bisector(static_cast<NearBisector::Kind>(number % 3), random);
            Options options = options_in(set.solid);
            options.box = test::cube(-2, 2);
            if (number % 2 == 0) options.periodic = {true, true, true};
            const Tessellation t = votess::tessellate(set.points, options);
            std::vector<std::int64_t> ids(1);
            for (std::size_t i = 0; i < t.size(); i += 3) {
                ids[0] = static_cast<std::int64_t>(i);
                options.only = ids;
                const Tessellation one = votess::tessellate(set.points, options);
                CHECK(one.volumes()[0] == t.volumes()[i]);
                CHECK(one.mesh_areas()[0] == t.mesh_areas()[i]);
                CHECK(one.status()[0] == t.status()[i]);
                CHECK(std::ranges::equal(one.neighbors(0), t.neighbors(i)));
            }
        }
    }

    TEST_CASE("mesh: a cuboid has the cells of the box") {
        const votess::Box box{{0, -0.5, 0.25}, {1, 0.75, 2}};
        const Solid solid = test::cuboid({0, -0.5, 0.25}, {1, 0.75, 2});
        test::Random random(3);
        Coordinates points;
        for (std::size_t i = 0; i < 300; ++i)
            for (std::size_t k = 0; k < 3; ++k) points.push_back(random.uniform(box.lower[k], box.upper[k]));
        Options options = options_in(solid), in_box = options;
        in_box.mesh.reset();
        in_box.box = box;
        CHECK(difference(votess::tessellate(points, options), votess::tessellate(points, in_box)) == "");
        const std::vector<double> radii = random_seeds(100, 0, 0.1, 5);
        options.radii = in_box.radii = radii;
        CHECK(difference(votess::tessellate(points, options), votess::tessellate(points, in_box)) == "");
        for (double& x : points) x += x < 0.5 ? 0 : 0.25;  // some outside
        in_box.outside = votess::Outside::keep;
        CHECK(difference(votess::tessellate(points, options), votess::tessellate(points, in_box)) == "");
    }

    TEST_CASE("mesh: cells of a small cluster in a corner are those of the box, each area to the digits of its cell") {
        const Solid cube = test::cuboid(0, 1);
        Options options = options_in(cube), in_box = options;
        in_box.want.radii = true;
        in_box.mesh.reset();
        in_box.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        for (const int exponent : {-20, -30, -45, -300, -905, -1000})
            for (std::uint64_t number = 0; number < 10; ++number) {
                CAPTURE(exponent);
                CAPTURE(number);
                Coordinates points = random_seeds(8, 0, 1, number);
                for (double& x : points) x = std::ldexp(x, exponent);
                if (number % 2 == 1) points[0] = points[1] = points[2] = 0.5;
                const Tessellation t = votess::tessellate(points, options), box = votess::tessellate(points, in_box);
                REQUIRE(std::ranges::equal(t.indptr(), box.indptr()));
                CHECK(std::ranges::equal(t.indices(), box.indices()));
                double worst = 0;  // of areas, in units of the surface of the cell
                for (std::size_t i = 0; i < t.size() && exponent > -300; ++i)
                    for (auto e = static_cast<std::size_t>(t.indptr()[i]);
                         e < static_cast<std::size_t>(t.indptr()[i + 1]); ++e)
                        worst =
                            std::max(worst, std::abs(t.face_areas()[e] - box.face_areas()[e]) / box.surface_areas()[i]);
                CHECK(worst < 1e-13);
                CHECK(*std::ranges::min_element(box.security_radii()) > 0);
            }
    }

    TEST_CASE("mesh: thin cells have areas to their digits, also where triangles lie on faces") {
        for (const double x : {1.0, 0x1p-20, 0x1p-33})
            for (const double y : {1.0, 0x1p-40})
                for (const bool is_glued : {false, true}) {
                    CAPTURE(x);
                    CAPTURE(y);
                    CAPTURE(is_glued);
                    // Seeds on both sides of the plane where two cuboids meet.
                    const Solid whole = test::cuboid({0, 0, 0}, {x, y, 1});
                    const Solid halves = test::joined(test::cuboid({0, 0, 0}, {0.5 * x, y, 1}),
                                                      test::cuboid({0.5 * x, 0, 0}, {x, y, 1}));
                    Options options = options_in(is_glued ? halves : whole), in_box = options;
                    in_box.mesh.reset();
                    in_box.box = votess::Box{{0, 0, 0}, {x, y, 1}};
                    Coordinates points = random_seeds(4, 0, 1, 77);
                    for (std::size_t i = 0; i < 4; ++i) {
                        for (std::size_t k = 0; k < 2; ++k) points[3 * i + k] *= k == 0 ? 0.5 * x : y;
                        points.insert(points.end(), {x - points[3 * i], points[3 * i + 1], points[3 * i + 2]});
                    }
                    const Tessellation t = votess::tessellate(points, options),
                                       box = votess::tessellate(points, in_box);
                    REQUIRE(std::ranges::equal(t.indptr(), box.indptr()));
                    CHECK(std::ranges::equal(t.indices(), box.indices()));
                    double worst = 0;
                    for (std::size_t i = 0; i < t.size(); ++i)
                        for (auto e = static_cast<std::size_t>(t.indptr()[i]);
                             e < static_cast<std::size_t>(t.indptr()[i + 1]); ++e)
                            worst = std::max(
                                worst, std::abs(t.face_areas()[e] - box.face_areas()[e]) / box.surface_areas()[i]);
                    CHECK(worst < 1e-10);
                }
    }

    TEST_CASE("mesh: the same cells for other orders, places, threads and vertices") {
        const Solid ring = test::torus(16, 8);
        const std::size_t n = test::by_size(400, 100);
        const Coordinates points = random_seeds(n, -1.25, 1.25, 9);
        Options options = options_in(ring);
        options.box = test::cube(-2, 2);
        const Tessellation t = votess::tessellate(points, options);
        CHECK(t.in_mesh());
        CHECK(t.stats().empty_cells > 0);
        CHECK(t.stats().faces == t.indices().size());
        options.threads = 3;
        CHECK(difference(votess::tessellate(points, options), t, 0) == "");

        Solid shuffled = ring;
        test::Random random(4);
        const auto order = test::permutation(ring.vertices.size() / 3, random);
        for (std::size_t v = 0; v < order.size(); ++v)
            std::copy_n(&ring.vertices[3 * v], 3, &shuffled.vertices[3 * order[v]]);
        for (std::size_t i = 0; i < ring.triangles.size(); ++i)
            shuffled.triangles[i] = static_cast<std::int32_t>(order[static_cast<std::size_t>(ring.triangles[i])]);
        for (std::size_t i = 0; i < ring.triangles.size(); i += 6)
            std::rotate(&shuffled.triangles[i], &shuffled.triangles[i] + 1, &shuffled.triangles[i] + 3);
        options.mesh = shuffled.mesh();
        CHECK(difference(votess::tessellate(points, options), t) == "");

        // Reversed order of the seeds, and everything moved by a power of two.
        Coordinates moved(points.rbegin(), points.rend());
        Solid there = ring;
        for (auto* coordinates : {&moved, &there.vertices})
            for (double& x : *coordinates) x = std::round(x * 0x1p40) / 0x1p40;
        for (std::size_t i = 0; i < n; ++i) std::swap(moved[3 * i], moved[3 * i + 2]);
        Coordinates here = moved;
        for (auto* coordinates : {&moved, &there.vertices})
            for (double& x : *coordinates) x += 64;
        options.box.reset();
        options.mesh = there.mesh();
        const Tessellation far = votess::tessellate(moved, options);
        CHECK(check_sums(far, there) == "");
        for (std::size_t i = 0; i < n; ++i) {
            CHECK(std::abs(far.volumes()[i] - t.volumes()[n - 1 - i]) < 1e-10);
            CHECK(far.neighbors(i).size() == t.neighbors(n - 1 - i).size());
        }

        std::vector<std::int64_t> ids{5, 3, static_cast<std::int64_t>(n) - 1, 77};
        options.mesh = ring.mesh();
        options.box = test::cube(-2, 2);
        options.only = ids;
        const Tessellation some = votess::tessellate(points, options);
        REQUIRE(some.size() == ids.size());
        for (std::size_t k = 0; k < ids.size(); ++k) {
            const auto i = static_cast<std::size_t>(ids[k]);
            CHECK(some.volumes()[k] == t.volumes()[i]);
            CHECK(std::abs(some.mesh_areas()[k] - t.mesh_areas()[i]) < 1e-13);
            CHECK(std::ranges::equal(some.neighbors(k), t.neighbors(i)));
        }
        options.only = std::span<const std::int64_t>();
        CHECK(votess::tessellate(points, options).size() == 0);
    }

    TEST_CASE("mesh: the same rows for some cells, where faces lie in the surface") {
        const Solid unit = test::cuboid(0, 1);
        const Solid blocks = test::joined(test::joined(unit, test::cuboid({1, 0, 0}, {2, 1, 1})),
                                          test::cuboid({0.5, 0.5, 1}, {1.5, 1.25, 1.5}));
        for (const double shift : {0.0, 0.125}) {
            const Coordinates points = lattice(-0.25 + shift, 1.75 + shift, 0.25);
            Options options = options_in(blocks);
            options.box = test::cube(-3, 3);
            const Tessellation t = votess::tessellate(points, options);
            CHECK(check_sums(t, blocks) == "");
            std::vector<std::int64_t> ids(1);
            for (std::size_t i = 0; i < t.size(); i += 7) {
                CAPTURE(i);
                ids[0] = static_cast<std::int64_t>(i);
                options.only = ids;
                const Tessellation one = votess::tessellate(points, options);
                CHECK(std::abs(one.volumes()[0] - t.volumes()[i]) < 1e-14);
                CHECK(std::abs(one.mesh_areas()[0] - t.mesh_areas()[i]) < 1e-14);
                CHECK(std::abs(one.surface_areas()[0] - t.surface_areas()[i]) < 1e-14);
                CHECK(one.status()[0] == t.status()[i]);
                const auto row = t.neighbors(i);
                CHECK(std::ranges::equal(one.neighbors(0), row));
                for (std::size_t k = 0; k < std::min(row.size(), one.face_areas().size()); ++k)
                    CHECK(std::abs(one.face_areas()[k] - t.face_areas()[static_cast<std::size_t>(t.indptr()[i]) + k]) <
                          1e-14);
            }
        }
    }

    TEST_CASE("mesh: far, tiny, thin and crowded") {
        const Solid solid =
            test::joined(test::torus(9, 5), test::tetrahedron({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 2}}}));
        Coordinates points = random_seeds(60, -1, 1, 21);
        for (const double scale : {0x1p-600, 1e-3, 0x1p300}) {
            CAPTURE(scale);
            Solid scaled = solid;
            Coordinates seeds = points;
            for (auto* coordinates : {&scaled.vertices, &seeds})
                for (double& x : *coordinates) x *= scale;
            const Tessellation t = votess::tessellate(seeds, options_in(scaled));
            if (scale == 1e-3) CHECK(check_sums(t, scaled) == "");
            const Tessellation plain = votess::tessellate(points, options_in(solid));
            if (scale == 1e-3) continue;
            CHECK(std::ranges::equal(t.indices(), plain.indices()));
            for (std::size_t k = 0; k < t.centroids().size(); ++k)  // also where volumes are no numbers
                CHECK((t.centroids()[k] == plain.centroids()[k] * scale || std::isnan(plain.centroids()[k])));
        }
        for (auto coordinates = points; const double offset : {1e6, 1e12}) {
            CAPTURE(offset);
            Solid moved = solid;
            for (auto* all : {&moved.vertices, &coordinates})
                for (double& x : *all) x += offset;
            CHECK(check_sums(votess::tessellate(coordinates, options_in(moved)), moved, 1e-10) == "");
            coordinates = points;
        }
        for (std::size_t i = 90; i < points.size(); ++i)  // a step of rounding apart
            points[i] = std::nextafter(points[i - 90], i % 2 == 0 ? 9 : -9);
        CHECK(check_sums(votess::tessellate(points, options_in(solid)), solid) == "");
        const Solid needle = test::cuboid({-1, -1e-9, -1e-6}, {1, 1e-9, 1e-6});
        CHECK(check_sums(votess::tessellate(points, options_in(needle)), needle, 1e-7) == "");
        // Triangles without an area, and vertices of no triangle.
        Solid odd = test::cuboid(-0.5, 0.5);
        odd.vertices.insert(odd.vertices.end(), {9, 9, 9});
        odd.triangles.insert(odd.triangles.end(), {0, 1, 1, 2, 2, 2});
        CHECK(check_sums(votess::tessellate(points, options_in(odd)), odd) == "");
        CHECK(votess::tessellate(Coordinates{}, options_in(odd)).size() == 0);
    }

    TEST_CASE("mesh: in a periodic domain a cell has the parts of all its images") {
        test::Random random(45);
        for (std::size_t run = 0; run < test::by_size(60, 16); ++run) {
            CAPTURE(run);
            const bool ties = run % 2 == 0, skewed = run % 3 == 2, whole = run % 8 == 0 && !skewed;
            const std::array<bool, 3> periodic{true, skewed || run % 4 != 1, skewed || run % 4 < 2};
            std::array<std::array<double, 3>, 3> edges{};
            for (std::size_t k = 0; k < 3; ++k) edges[k][k] = ties || skewed ? 1 : 0.7;
            if (skewed) edges[1][0] = 0.25, edges[2] = {0.125, -0.25, 1};
            const double lower = ties || skewed ? 0 : 0.1;
            const auto place = [&](std::array<double, 3> f) {
                std::array<double, 3> x{lower, lower, lower};
                for (std::size_t j = 0; j < 3; ++j)
                    for (std::size_t k = 0; k < 3; ++k) x[k] += f[j] * edges[j][k];
                return x;
            };
            // Seeds are given up to two boxes away.
            Coordinates points, inside;
            for (std::size_t i = 0; i < 1 + run % 9; ++i) {
                std::array<double, 3> f;
                for (double& x : f) x = ties ? std::floor(random.uniform(1, 8)) / 8 : random.uniform(0.01, 0.99);
                const auto x = place(f);
                inside.insert(inside.end(), x.begin(), x.end());
                for (std::size_t k = 0; k < 3; ++k)
                    if (periodic[k] && ties) f[k] += std::floor(random.uniform(-2, 3));
                const auto given = place(f);
                points.insert(points.end(), given.begin(), given.end());
            }
            const std::size_t n = points.size() / 3;
            std::vector<double> weights(n);
            for (double& w : weights) w = run % 5 < 3 ? 0 : std::floor(random.uniform(0, 3)) / 32;
            Solid solid = run % 4 == 3 ? test::torus(9, 5) : test::cuboid(-1.25, 1.25);
            for (std::size_t c = 0; c < solid.vertices.size(); ++c)
                solid.vertices[c] = lower + (ties || skewed ? 0.5 : 0.35) +
                                    solid.vertices[c] * (whole    ? 0.4
                                                         : skewed ? 0.125
                                                                  : 0.2);
            if (skewed)
                for (std::size_t c = 0; c < solid.vertices.size(); c += 3) solid.vertices[c] += 0.1875;
            Options options = options_in(solid);
            options.weights = weights;
            if (skewed) {
                options.cell = votess::TriclinicBox{{}, edges[0], edges[1], edges[2], {true, true, true}};
            } else {
                options.box = test::cube(lower, place({1, 1, 1})[0]);
                options.periodic = periodic;
                if (whole) options.periodic = {true, true, true};
            }
            const std::array<bool, 3> repeats = skewed ? periodic : options.periodic;
            const Tessellation t = votess::tessellate(points, options);
            CHECK(std::abs(sum(t.volumes()) / solid.volume() - 1) < 1e-13);
            CHECK(std::abs(sum(t.mesh_areas()) / solid.area() - 1) < 1e-13);
            CHECK(check_pieces(t, votess::pieces(t)) == "");

            // The same from seeds at the places of all images.
            Coordinates images;
            std::vector<double> heavy;
            std::vector<std::array<int, 3>> shifts;
            for (int a = repeats[0] ? -2 : 0; a <= (repeats[0] ? 2 : 0); ++a)
                for (int b = repeats[1] ? -2 : 0; b <= (repeats[1] ? 2 : 0); ++b)
                    for (int c = repeats[2] ? -2 : 0; c <= (repeats[2] ? 2 : 0); ++c) {
                        shifts.push_back({a, b, c});
                        const auto by = place({double(a), double(b), double(c)});
                        for (std::size_t i = 0; i < 3 * n; ++i) images.push_back(inside[i] + by[i % 3] - lower);
                        heavy.insert(heavy.end(), weights.begin(), weights.end());
                    }
            Options alone = options_in(solid);
            alone.weights = heavy;
            alone.box = test::cube(-4, 5);
            for (std::size_t k = 0; k < 3; ++k)
                if (!repeats[k]) alone.box->lower[k] = lower, alone.box->upper[k] = options.box->upper[k];
            const Tessellation all = votess::tessellate(images, alone);
            using Face = std::tuple<std::int32_t, std::int32_t, std::array<int, 3>>;
            std::map<Face, double> expected, found;
            Coordinates volumes(n), moments(3 * n);
            for (std::size_t i = 0; i < all.size(); ++i) {
                const auto& from = shifts[i / n];
                const auto by = place({double(from[0]), double(from[1]), double(from[2])});
                volumes[i % n] += all.volumes()[i];
                for (std::size_t k = 0; k < 3 && all.volumes()[i] > 0; ++k)
                    moments[3 * (i % n) + k] += all.volumes()[i] * (all.centroids()[3 * i + k] - by[k] + lower);
                for (auto e = all.indptr()[i]; e < all.indptr()[i + 1]; ++e) {
                    const auto j = static_cast<std::size_t>(all.indices()[static_cast<std::size_t>(e)]);
                    std::array<int, 3> shift = shifts[j / n];
                    for (std::size_t k = 0; k < 3; ++k) shift[k] -= from[k];
                    expected[{static_cast<std::int32_t>(i % n), static_cast<std::int32_t>(j % n), shift}] +=
                        all.face_areas()[static_cast<std::size_t>(e)];
                }
            }
            for (std::size_t i = 0; i < n; ++i) {
                CHECK(std::abs(t.volumes()[i] - volumes[i]) < 1e-13);
                for (std::size_t k = 0; k < 3 && t.volumes()[i] > 0; ++k)
                    CHECK(std::abs(t.volumes()[i] * t.centroids()[3 * i + k] - moments[3 * i + k]) < 1e-13);
                for (auto e = static_cast<std::size_t>(t.indptr()[i]); e < static_cast<std::size_t>(t.indptr()[i + 1]);
                     ++e)
                    found[{static_cast<std::int32_t>(i),
                           t.indices()[e],
                           {t.shifts()[3 * e], t.shifts()[3 * e + 1], t.shifts()[3 * e + 2]}}] = t.face_areas()[e];
            }
            CHECK(found.size() == expected.size());
            for (const auto& [face, area] : expected) {
                const auto& [i, j, shift] = face;
                CHECK(std::abs(found[face] - area) < 1e-13);
                CHECK(found[{j, i, {-shift[0], -shift[1], -shift[2]}}] == found[face]);
            }
        }
    }

    TEST_CASE("mesh: vertices at equal places are one on demand") {
        const Solid unit = test::cuboid(0, 1);
        Solid corners;  // each triangle has vertices of its own
        for (const std::int32_t v : unit.triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                const double x = unit.vertices[3 * static_cast<std::size_t>(v) + k];
                corners.vertices.push_back(x == 0 && corners.triangles.size() % 2 == 0 ? -0.0 : x);
            }
            corners.triangles.push_back(static_cast<std::int32_t>(corners.triangles.size()));
        }
        const Coordinates points = random_seeds(50, 0.1, 0.9, 2);
        Options options = options_in(corners);
        CHECK(test::has(test::refusal(points, options), "merge vertices at equal places"));
        options.mesh->merge = true;
        const Tessellation ours = votess::tessellate(points, options),
                           plain = votess::tessellate(points, options_in(unit));
        CHECK(std::ranges::equal(ours.indices(), plain.indices()));
        for (std::size_t i = 0; i < points.size() / 3; ++i)
            CHECK(ours.volumes()[i] == doctest::Approx(plain.volumes()[i]).epsilon(1e-13));
        corners.triangles.erase(corners.triangles.begin(), corners.triangles.begin() + 3);
        options.mesh->triangles = corners.triangles;
        const std::string message = test::refusal(points, options);
        CHECK(test::has(message, "close the hole"));
        CHECK_FALSE(test::has(message, "merge"));
    }

    TEST_CASE("mesh: vertices that rounding sets apart are one within a tolerance") {
        test::Random random(60);
        for (const double size : {1.0, 1e-3, 1e6})
            for (const double noise : {1e-15, 1e-10, 1e-4}) {
                Solid ring = test::torus(12, 6), corners;
                for (double& x : ring.vertices) x *= size;
                for (const std::int32_t v : ring.triangles) {
                    std::array<double, 3> x;
                    for (std::size_t k = 0; k < 3; ++k)
                        x[k] =
                            ring.vertices[3 * static_cast<std::size_t>(v) + k] + size * noise * random.uniform(-1, 1);
                    corners.vertices.insert(corners.vertices.end(), x.begin(), x.end());
                    corners.triangles.push_back(static_cast<std::int32_t>(corners.triangles.size()));
                }
                const Coordinates points = random_seeds(30, -size, size, 3);
                Options options = options_in(corners);
                options.mesh->merge = true;
                const std::string message = test::refusal(points, options);
                CAPTURE(message);
                CHECK(test::has(message, "432 edges are open or turned"));
                CHECK(test::has(message, "merge near vertices: Options::mesh.tolerance = "));
                options.mesh->tolerance = 2 * noise;  // of the size, 2.8
                const Tessellation t = votess::tessellate(points, options);
                CHECK(std::abs(t.stats().box_volume / ring.volume() - 1) < 100 * noise);
                CHECK(std::abs(t.stats().volume_sum / t.stats().box_volume - 1) < 1e-12);
                CHECK(t.stats().moved_vertices > 350);
                const double farthest = t.stats().moved_distance;
                CHECK(farthest > 0);
                CHECK(farthest < 2 * std::sqrt(3) * size * noise * 1.001);
                CHECK(votess::pieces(t).size() > 0);
                options.mesh->merge = false;
                CHECK(test::has(test::refusal(points, options), "Options::mesh.tolerance needs Options::mesh.merge"));
            }
        const Solid unit = test::cuboid(0, 1);
        Options options = options_in(unit);
        options.mesh->merge = true;
        for (const double tolerance : {-1e-9, 0.011, std::numeric_limits<double>::quiet_NaN()}) {
            options.mesh->tolerance = tolerance;
            CHECK(test::has(test::refusal(random_seeds(5, 0.1, 0.9, 1), options), "Options::mesh.tolerance is "));
        }
    }

    TEST_CASE("mesh: refusals name the first edge, triangle or vertex") {
        const Coordinates points = random_seeds(5, 0.1, 0.9, 1);
        const Solid unit = test::cuboid(0, 1);
        const auto message = [&](const Solid& solid) { return test::refusal(points, options_in(solid)); };
        Solid bad = unit;
        bad.triangles.erase(bad.triangles.begin(), bad.triangles.begin() + 3);
        CHECK(message(bad) ==
              "Options::mesh: the edge between vertices 0 (0, 0, 0) and 1 (0, 0, 1) belongs to triangle 4 alone; 3 "
              "edges are "
              "open or turned in all: close the hole, or merge vertices at equal places: Options::mesh.merge");
        bad = unit;
        std::swap(bad.triangles[9], bad.triangles[10]);
        CHECK(test::has(message(bad), ": reverse one of them, or those around it"));
        bad = unit;
        bad.triangles[7] = 9;
        CHECK(message(bad) == "Options::mesh: triangle 2 names vertex 9, but there are 8: give indices from 0 on");
        bad.triangles[7] = -1;
        CHECK(test::has(message(bad), "triangle 2 names vertex -1"));
        bad = unit;
        bad.vertices[10] = std::numeric_limits<double>::quiet_NaN();
        CHECK(message(bad) == "Options::mesh: vertex 3: y = nan is not finite");
        bad = unit;
        bad.vertices[10] = std::numeric_limits<double>::infinity();
        CHECK(message(bad) == "Options::mesh: vertex 3: y = inf is not finite");
        bad.vertices[10] = 1e308;
        bad.vertices[1] = -1e308;
        CHECK(test::has(message(bad), "exceeds the largest double"));
        bad.triangles.clear();
        CHECK(test::has(message(bad), "no triangles"));
        bad.triangles = {0, 1, 2, 0, 2, 1};
        CHECK(message(bad) == "Options::mesh: it encloses no volume");
        bad = unit;
        bad.triangles.insert(bad.triangles.end(), {0, 4, 5});
        CHECK(message(bad) ==
              "Options::mesh: triangles 4 and 12 are the same; 3 edges are open or turned in all: remove one of them");
        bad = unit;
        bad.vertices.insert(bad.vertices.end(), {0.5, 0.5, 2});
        bad.triangles.insert(bad.triangles.end(), {0, 1, 8});
        CHECK(test::has(message(bad), "belongs to 3 triangles, 1 more in one direction"));
        CHECK(test::has(message(unit.reversed()), "face inward"));
        bad = unit;
        bad.vertices.pop_back();
        CHECK(test::has(message(bad), "vertices hold 23 numbers"));
        bad = unit;
        bad.triangles.pop_back();
        CHECK(test::has(message(bad), "triangles hold 35 numbers"));
        bad = unit;
        bad.vertices.assign(24, 0.5);
        CHECK(test::has(message(bad), "it encloses no volume"));

        Options options = options_in(unit);
        options.box = test::unit_box();
        CHECK(test::has(test::refusal(points, options), "strictly inside"));
        const auto unsupported = [&](auto change) {
            Options changed = options_in(unit);
            changed.box = test::cube(-1, 2);
            change(changed);
            return test::refusal(points, changed, votess::ErrorCode::unsupported);
        };
        CHECK(test::has(unsupported([](Options& o) {
                            o.box.reset();
                            o.cell = votess::TriclinicBox{{}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}, {true, false, true}};
                        }),
                        "repeat along all its edges"));
        Options moved = options_in(unit);
        moved.cell = votess::TriclinicBox{{0.5, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {true, true, true}};
        CHECK(test::has(test::refusal(points, moved), "outside of the cell"));
        moved.cell.reset();
        moved.box = test::cube(0.5, 2);
        moved.periodic = {true, true, true};
        CHECK(test::has(test::refusal(points, moved), "it reaches x = 0, and the box spans 0.5 to 2"));
        CHECK(test::has(unsupported([](Options& o) { o.walls = test::octahedron(1); }), "it replaces Options::walls"));
        CHECK(test::has(unsupported([](Options& o) { o.outside = votess::Outside::keep; }), "outside"));
        CHECK(test::has(unsupported([](Options& o) { o.want.faces = true; }), "want"));
        CHECK(test::has(unsupported([](Options& o) { o.want.radii = true; }),
                        "leave the other groups out of Options::want"));
        CHECK(test::has(unsupported([](Options& o) { o.planar = true, o.cell = votess::TriclinicBox{}; }),
                        "three dimensions"));
        CHECK(test::has(unsupported([](Options& o) { o.box->upper[0] = std::numeric_limits<double>::infinity(); }),
                        "Options::box needs ends"));
    }

    TEST_CASE("mesh: small faces are dropped by their areas inside") {
        for (const bool periodic : {false, true}) {
            const Solid ring = test::torus(12, 6);
            const Coordinates points = random_seeds(60, -1.4, 1.4, 9);
            Options options = options_in(ring);
            options.want.normals = true;
            if (periodic) options.box = test::cube(-1.5, 1.5), options.periodic = {true, true, true};
            const Tessellation all = votess::tessellate(points, options);
            options.min_face = 0.3;
            const Tessellation some = votess::tessellate(points, options);
            const double least = 0.3 * sum(all.face_areas()) / static_cast<double>(all.face_areas().size());
            CHECK(some.least_face() == doctest::Approx(least).epsilon(1e-12));
            CHECK(some.stats().faces == some.indices().size());
            std::size_t entry = 0;
            for (std::size_t i = 0; i < all.size(); ++i) {
                CHECK(static_cast<std::size_t>(some.indptr()[i]) == entry);
                for (auto e = static_cast<std::size_t>(all.indptr()[i]);
                     e < static_cast<std::size_t>(all.indptr()[i + 1]); ++e) {
                    if (all.face_areas()[e] < least) continue;
                    REQUIRE(entry < some.indices().size());
                    CHECK(some.indices()[entry] == all.indices()[e]);
                    CHECK(some.face_areas()[entry] == all.face_areas()[e]);
                    CHECK(some.face_normals()[3 * entry + 2] == all.face_normals()[3 * e + 2]);
                    ++entry;
                }
            }
            CHECK(entry == some.indices().size());
            CHECK(entry < all.indices().size());
            CHECK(std::ranges::equal(some.volumes(), all.volumes()));
            CHECK(std::ranges::equal(some.surface_areas(), all.surface_areas()));
            CHECK(votess::verify(some, points).failure == "");
            options.min_face = 0;
            options.min_area = least;
            CHECK(std::ranges::equal(votess::tessellate(points, options).indices(), some.indices()));
        }
    }

    TEST_CASE("mesh: verify() checks the parts of cells") {
        const Solid ring = test::torus(12, 6);
        Coordinates points = random_seeds(60, -1.4, 1.4, 9);
        Options options = options_in(ring);
        CHECK(votess::verify(votess::tessellate(points, options), points).failure == "");
        options.box = test::cube(-1.5, 1.5);
        options.periodic = {true, true, true};
        const std::vector<double> weights = random_seeds(20, 0, 0.2, 3);
        options.weights = weights;
        const Tessellation t = votess::tessellate(points, options);
        const votess::VerifyReport report = votess::verify(t, points);
        CHECK(report.passed);
        CHECK(report.skipped.empty());
        points[0] += 0.3;
        CHECK(test::has(votess::verify(t, points).failure, "second run"));
        const std::vector<std::int64_t> ids{3};
        options.only = ids;
        CHECK(votess::verify(votess::tessellate(points, options), points).failure == "");
    }

    TEST_CASE("mesh: pieces of a torus, a comb, a spring and a shell") {
        const auto pieces_of = [](const Solid& solid, const Coordinates& points, std::vector<std::int64_t> counts,
                                  int handles) {
            const Tessellation t = votess::tessellate(points, options_in(solid));
            const votess::Pieces pieces = votess::pieces(t);
            int found = 0;
            CHECK(check_pieces(t, pieces, &found) == "");
            CHECK(piece_counts(pieces) == counts);
            CHECK(found == handles);
            return pieces;
        };
        const Solid ring = test::torus(24, 12);
        pieces_of(ring, {0.1, 0.2, 0.3}, {1}, 1);
        pieces_of(ring, {-1, 0.01, 0.02, 1, 0.02, 0.01}, {1, 1}, 0);
        pieces_of(ring, {-0.6, 0, 0.01, 0.01, 0, 0, 0.6, 0.01, 0}, {1, 2, 1}, 0);
        pieces_of(ring, {0, 0.01, -0.3, 0.01, 0, 0, 0, 0, 0.3}, {1, 1, 1}, 3);  // across the axis: annuli
        // A back with five teeth, and two seeds that part them from it.
        std::vector<bool> comb(9 * 1 * 3);
        for (std::size_t x = 0; x < 9; ++x)
            for (std::size_t z = 0; z < 3; ++z) comb[3 * x + z] = z == 0 || x % 2 == 0;
        const votess::Pieces teeth = pieces_of(test::cubes({9, 1, 3}, comb), {4.4, 0.4, 1, 4.4, 0.4, 2}, {1, 5}, 0);
        CHECK(teeth.volumes[1] == doctest::Approx(1.5));
        pieces_of(test::spring(3, 16, 7), {-0.5, 0.01, 1.4, 0.5, 0, 1.5}, {3, 4}, 0);
        const Solid shell = test::joined(test::cuboid(0, 1), test::cuboid(0.25, 0.75).reversed());
        const votess::Pieces hollow = pieces_of(shell, {0.4, 0.4, 0.4}, {1}, 0);
        CHECK(hollow.triangles.size() == shell.triangles.size());
        CHECK(hollow.volumes[0] == doctest::Approx(0.875));
        pieces_of(test::joined(shell, test::cuboid(0.375, 0.625)), {0.4, 0.4, 0.4}, {2}, 0);
        pieces_of(shell, {0.4, 0.4, 0.1, 0.4, 0.4, 0.5}, {1, 1}, 0);  // two bowls
        // Cubes that touch in a face or an edge.
        pieces_of(test::joined(test::cuboid(0, 1), test::cuboid({1, 0, 0}, {2, 1, 1})), {0.9, 0.4, 0.3}, {2}, 0);
        pieces_of(test::cubes({2, 2, 1}, {true, false, false, true}), {0.9, 0.4, 0.3}, {2}, 0);
        // Triangles of no area at the edges of others.
        Solid thin = test::cuboid(0, 1);
        thin.vertices.insert(thin.vertices.end(), {0.5, 0, 0});
        thin.triangles.insert(thin.triangles.end(), {0, 4, 8, 4, 0, 8, 5, 5, 6, 6, 6, 5});
        pieces_of(thin, {0.2, 0.1, 0.3, 0.7, 0.6, 0.4}, {1, 1}, 0);
    }

    TEST_CASE("mesh: pieces have the faces and the surface of their cells") {
        const Solid ring = test::torus(24, 12);
        const Coordinates points = random_seeds(test::by_size(300, 80), -1.4, 1.4, 8);
        Options options = options_in(ring);
        const Tessellation t = votess::tessellate(points, options);
        const votess::Pieces pieces = votess::pieces(t);
        CHECK(check_pieces(t, pieces) == "");
        CHECK(check_sources(t, pieces, ring) == "");
        for (std::size_t i = 0; i < t.size(); ++i) {
            Coordinates sum(3);
            for (auto k = pieces.indptr[i]; k < pieces.indptr[i + 1]; ++k)
                for (std::size_t a = 0; a < 3; ++a)
                    sum[a] += pieces.volumes[static_cast<std::size_t>(k)] *
                              pieces.centroids[3 * static_cast<std::size_t>(k) + a];
            for (std::size_t a = 0; a < 3 && t.volumes()[i] > 0; ++a)
                CHECK(std::abs(sum[a] - t.volumes()[i] * t.centroids()[3 * i + a]) < 1e-13);
        }
        votess::PieceOptions choice;
        choice.threads = 3;
        const votess::Pieces again = votess::pieces(t, choice);
        votess::PieceOptions many;
        many.threads = 100'000;
        CHECK_THROWS_WITH_AS((void)votess::pieces(t, many), "PieceOptions::threads = 100000: give 0 to 1024",
                             votess::Error);
        CHECK(again.vertices == pieces.vertices);
        CHECK(again.triangles == pieces.triangles);
        const std::vector<std::int64_t> ids{7, 3};
        options.only = ids;
        const votess::Pieces some = votess::pieces(votess::tessellate(points, options));
        REQUIRE(some.indptr.size() == 3);
        CHECK(some.indptr[1] == pieces.indptr[8] - pieces.indptr[7]);
    }

    TEST_CASE("mesh: pieces are closed where seeds and mesh share planes") {
        test::Random random(43);
        for (std::size_t run = 0; run < test::by_size(60, 12); ++run) {
            CAPTURE(run);
            const std::array<int, 3> count{1 + static_cast<int>(random.uniform(0, 4)),
                                           1 + static_cast<int>(random.uniform(0, 4)),
                                           1 + static_cast<int>(random.uniform(0, 4))};
            std::vector<bool> filled(static_cast<std::size_t>(count[0] * count[1] * count[2]));
            for (std::size_t c = 0; c < filled.size(); ++c) filled[c] = random.uniform(0, 1) < 0.6;
            filled[0] = true;
            Solid solid = test::cubes(count, filled);
            const int parts = connected_cubes(count, filled);
            const Tessellation whole = votess::tessellate(Coordinates{0.3, 0.4, 0.6}, options_in(solid));
            CHECK(check_pieces(whole, votess::pieces(whole)) == "");
            CHECK(piece_counts(votess::pieces(whole)) == std::vector<std::int64_t>{parts});
            if (run % 3 == 1) solid = test::torus(4 + static_cast<int>(run) % 5, 3 + static_cast<int>(run) % 4);
            if (run % 6 == 1)
                for (double& x : solid.vertices) x = std::round(8 * x) / 8;
            Coordinates points = random_seeds(1 + run % 25, -1, 3, run);
            const double steps = 1 << run % 4;
            for (double& x : points) x = run % 5 == 0 ? x : std::round(steps * x) / steps;
            if (run % 7 == 3) points.insert(points.end(), solid.vertices.begin(), solid.vertices.end());
            const Tessellation t = votess::tessellate(points, options_in(solid));
            CHECK(check_pieces(t, votess::pieces(t)) == "");
        }
    }

    TEST_CASE("mesh: pieces of cells whose faces lie in the surface") {
        test::Random random(44);
        for (std::size_t run = 0; run < test::by_size(40, 10); ++run) {
            CAPTURE(run);
            const std::array<int, 3> count{3, 2 + static_cast<int>(run) % 3, 2}, half{6, 2 * count[1], 4};
            std::vector<bool> filled(static_cast<std::size_t>(count[0] * count[1] * count[2]));
            for (std::size_t c = 0; c < filled.size(); ++c) filled[c] = random.uniform(0, 1) < 0.6;
            filled[0] = true;
            // Planes between cells lie at multiples of 0.5, so that each cell is a union of cubes of half the size.
            std::array<std::vector<double>, 3> along;
            for (std::size_t k = 0; k < 3; ++k) {
                const double step = std::array{0.5, 1.0, 1.5, 2.0}[static_cast<std::size_t>(random.uniform(0, 4))];
                double x = -0.5 * std::floor(random.uniform(1, 4)) - 0.5 * step;
                for (; x < count[k] + 2; x += step) along[k].push_back(x);
            }
            Coordinates points;
            std::vector<std::int64_t> counts;
            for (const double x : along[0])
                for (const double y : along[1])
                    for (const double z : along[2]) {
                        points.insert(points.end(), {x, y, z});
                        const std::array<double, 3> seed{x, y, z};
                        std::vector<bool> cell(8 * filled.size());
                        for (std::size_t c = 0; c < cell.size(); ++c) {
                            const int at = static_cast<int>(c);
                            const std::array<int, 3> cube{at / (half[1] * half[2]), at / half[2] % half[1],
                                                          at % half[2]};
                            bool inside = filled[static_cast<std::size_t>(
                                (cube[0] / 2 * count[1] + cube[1] / 2) * count[2] + cube[2] / 2)];
                            for (std::size_t k = 0; k < 3; ++k)
                                for (const double other : along[k])
                                    if (std::abs(0.5 * cube[k] + 0.25 - other) <
                                        std::abs(0.5 * cube[k] + 0.25 - seed[k]))
                                        inside = false;
                            cell[c] = inside;
                        }
                        counts.push_back(connected_cubes(half, cell));
                    }
            const Tessellation t = votess::tessellate(points, options_in(test::cubes(count, filled)));
            const votess::Pieces pieces = votess::pieces(t);
            CHECK(check_pieces(t, pieces) == "");
            CHECK(piece_counts(pieces) == counts);
        }
    }

    TEST_CASE("mesh: triangles on the surface face as their sources, where boxes overlap or are cavities") {
        test::Random random(71);
        for (std::size_t run = 0; run < test::by_size(150, 40); ++run) {
            Solid solid;
            for (std::size_t n = 1 + random.below(3); n > 0; --n) {
                std::array<double, 3> lower, upper;
                for (std::size_t k = 0; k < 3; ++k) {
                    lower[k] = static_cast<double>(random.integer(0, 4));
                    upper[k] = lower[k] + static_cast<double>(random.integer(1, 4));
                }
                const Solid box = test::cuboid(lower, upper);
                const bool reversed = !solid.triangles.empty() && random.chance(0.35);
                solid = solid.triangles.empty() ? box : test::joined(solid, reversed ? box.reversed() : box);
            }
            if (solid.volume() <= 0) continue;
            Coordinates points;
            for (std::size_t i = 6 + 3 * random.below(12); i > 0; --i)
                points.push_back(0.5 * static_cast<double>(random.integer(0, 8)));
            const votess::Pieces pieces = votess::pieces(votess::tessellate(points, options_in(solid)));
            const auto normal = [](const double* vertices, const std::int32_t* corners) {
                const auto at = [&](std::size_t c, std::size_t k) {
                    return vertices[3 * static_cast<std::size_t>(corners[c]) + k] -
                           vertices[3 * static_cast<std::size_t>(corners[0]) + k];
                };
                std::array<double, 3> n;
                for (std::size_t k = 0; k < 3; ++k)
                    n[k] = at(1, (k + 1) % 3) * at(2, (k + 2) % 3) - at(1, (k + 2) % 3) * at(2, (k + 1) % 3);
                return n;
            };
            double max_against = 0;
            for (std::size_t p = 0; p < pieces.size(); ++p)
                for (auto f = pieces.triangle_offsets[p]; f < pieces.triangle_offsets[p + 1]; ++f) {
                    const auto t = static_cast<std::size_t>(f);
                    if (pieces.on_surface[t] == 0) continue;
                    const auto a = normal(&pieces.vertices[3 * static_cast<std::size_t>(pieces.vertex_offsets[p])],
                                          &pieces.triangles[3 * t]);
                    const auto b = normal(solid.vertices.data(),
                                          &solid.triangles[3 * static_cast<std::size_t>(pieces.sources[t])]);
                    max_against = std::max(max_against, -(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]));
                }
            CAPTURE(run);
            CHECK(max_against < 1e-12);
        }
    }

    TEST_CASE("mesh: a gap between pieces") {
        // Cubes of 0.5, of which each loses 0.05 at its three inner faces.
        const Solid unit = test::cuboid(0, 1);
        Coordinates points;
        for (const double x : {0.25, 0.75})
            for (const double y : {0.25, 0.75})
                for (const double z : {0.25, 0.75}) points.insert(points.end(), {x, y, z});
        Options options = options_in(unit);
        const Tessellation t = votess::tessellate(points, options);
        votess::PieceOptions choice;
        choice.gap = 0.1;
        for (const double volume : votess::pieces(t, choice).volumes)
            CHECK(std::abs(volume - 0.45 * 0.45 * 0.45) < 1e-15);
        choice.gap = 1;
        CHECK(votess::pieces(t, choice).size() == 0);
        // No vertex of a piece is nearer to a plane than half of the gap. The planes of a power diagram are shifted.
        points = random_seeds(40, 0, 1, 6);
        const std::vector<double> weights = random_seeds(14, 0, 0.03, 2);
        options.weights = std::span(weights).first(40);
        choice.gap = 0.03;
        const Tessellation power = votess::tessellate(points, options);
        const votess::Pieces apart = votess::pieces(power, choice);
        for (std::size_t i = 0; i < power.size(); ++i)
            for (auto k = apart.indptr[i]; k < apart.indptr[i + 1]; ++k) {
                const View piece(apart, static_cast<std::size_t>(k));
                int handles = 0;
                CHECK(check_closed(piece, handles) == "");
                for (std::size_t f = 0; 3 * f < piece.triangles.size(); ++f) {
                    if (apart.on_surface[piece.first + f] != 0) continue;
                    const auto j = static_cast<std::size_t>(apart.sources[piece.first + f]);
                    const double* x = &piece.vertices[3 * static_cast<std::size_t>(piece.triangles[3 * f])];
                    double to_i = -weights[i], to_j = -weights[j], between = 0;
                    for (std::size_t a = 0; a < 3; ++a) {
                        to_i += (x[a] - points[3 * i + a]) * (x[a] - points[3 * i + a]);
                        to_j += (x[a] - points[3 * j + a]) * (x[a] - points[3 * j + a]);
                        between += (points[3 * i + a] - points[3 * j + a]) * (points[3 * i + a] - points[3 * j + a]);
                    }
                    CHECK(std::abs((to_j - to_i) / (2 * std::sqrt(between)) - 0.015) < 1e-13);
                }
            }
        for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
            choice.gap = bad;
            CHECK(test::error_of([&] { (void)votess::pieces(t, choice); }) == votess::ErrorCode::invalid_argument);
        }
        // Arrays of a run in a mesh are used again for one without.
        votess::Tessellator tessellator;
        (void)tessellator.tessellate(points, options_in(unit));
        Options plain;
        plain.device = "cpu";
        const Tessellation outside = tessellator.tessellate(points, plain);
        CHECK_FALSE(outside.in_mesh());
        CHECK(test::error_of([&] { (void)votess::pieces(outside); }) == votess::ErrorCode::invalid_argument);
    }
}
