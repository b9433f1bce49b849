// verify() of polygons, where corners are proven once: what it must notice, and that it proves what it should.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <numeric>
#include <set>

#include "input/settle.hpp"
#include "result/arrays.hpp"
#include "result/handle.hpp"
#include "result/rows.hpp"
#include "support/check.hpp"
#include "support/proof_case.hpp"
#include "verify/certificate.hpp"
#include "verify/shared_corners.hpp"

namespace {

using test::ProofCase;
using votess::FaceLabel;
using votess::detail::Result;

std::shared_ptr<Result> copy_of(const votess::Tessellation& t) {
    const Result& from = votess::detail::result_of(t);
    auto to = std::make_shared<Result>();
    to->box = from.box, to->periodic = from.periodic, to->cell = from.cell, to->walls = from.walls;
    to->lists_walls = from.lists_walls, to->stats = from.stats;
    votess::detail::for_arrays([&](const auto& array) {
        array.of(*to).resize_uninitialized(array.of(from).size());
        std::ranges::copy(array.of(from), array.of(*to).begin());
    });
    return to;
}

std::size_t at(std::int64_t k) {
    return static_cast<std::size_t>(k);
}

std::span<std::int32_t> polygon(Result& r, std::size_t entry) {
    return std::span<std::int32_t>(r.face_vertices)
        .subspan(at(r.face_offsets[entry]), at(r.face_offsets[entry + 1] - r.face_offsets[entry]));
}

std::span<const std::int32_t> polygon(const Result& r, std::size_t entry) {
    return std::span<const std::int32_t>(r.face_vertices)
        .subspan(at(r.face_offsets[entry]), at(r.face_offsets[entry + 1] - r.face_offsets[entry]));
}

// The faces of a cell that meet at each of its vertices.
using CornerNames = std::map<std::int32_t, std::set<FaceLabel>>;
CornerNames corner_names(const Result& r, const votess::Rows& rows, std::size_t cell) {
    CornerNames names;
    for (std::size_t e = rows.begin(cell); e < rows.end(cell); ++e)
        for (const std::int32_t v : polygon(r, e)) names[v].insert(rows.label(e));
    return names;
}

// The polygons of a result, without the numbers of vertices: each corner is named by the faces of its cell that meet
// there, each polygon begins with its least one.
using Shape = std::vector<std::vector<std::pair<FaceLabel, std::vector<std::set<FaceLabel>>>>>;
Shape shape_of(const Result& r) {
    const votess::Rows rows{r.indptr, r.indices, r.shifts};
    Shape shape(r.status.size());
    for (std::size_t i = 0; i < shape.size(); ++i) {
        CornerNames names = corner_names(r, rows, i);
        for (std::size_t e = rows.begin(i); e < rows.end(i); ++e) {
            std::vector<std::set<FaceLabel>> corners;
            for (const std::int32_t v : polygon(r, e)) corners.push_back(names[v]);
            std::ranges::rotate(corners, std::ranges::min_element(corners));
            shape[i].emplace_back(rows.label(e), std::move(corners));
        }
    }
    return shape;
}

// Whether two results of the same shape have the same vertices, whatever the numbers of these, and whichever image of a
// vertex is the original.
bool same_vertices(const Result& a, const Result& b) {
    struct Corner {
        std::int32_t original;
        std::array<int, 3> shift{};
    };
    const auto corners = [](const Result& r) {  // of all polygons, from that of the least name on
        const votess::Rows rows{r.indptr, r.indices, r.shifts};
        std::vector<Corner> all;
        for (std::size_t i = 0; i < r.status.size(); ++i) {
            CornerNames names = corner_names(r, rows, i);
            for (std::size_t e = rows.begin(i); e < rows.end(i); ++e) {
                std::vector<std::int32_t> some(polygon(r, e).begin(), polygon(r, e).end());
                std::ranges::rotate(some, std::ranges::min_element(
                                              some, {}, [&](std::int32_t v) -> const auto& { return names[v]; }));
                for (const std::int32_t v : some) {
                    Corner& corner = all.emplace_back(v);
                    if (r.vertex_image_of.empty()) continue;
                    corner.original = r.vertex_image_of[at(v)];
                    for (std::size_t d = 0; d < 3; ++d) corner.shift[d] = r.vertex_shifts[3 * at(v) + d];
                }
            }
        }
        return all;
    };
    using Originals = std::map<std::int32_t, Corner>;  // of one result: that of the other, and how far it is moved
    const auto fits = [](Originals& originals, const Corner& from, const Corner& to) {
        Corner there{to.original};
        for (std::size_t d = 0; d < 3; ++d) there.shift[d] = to.shift[d] - from.shift[d];
        const Corner& known = originals.emplace(from.original, there).first->second;
        return known.original == there.original && known.shift == there.shift;
    };
    const std::vector<Corner> x = corners(a), y = corners(b);
    Originals there, back;
    bool same = x.size() == y.size();
    for (std::size_t k = 0; k < x.size() && same; ++k) same = fits(there, x[k], y[k]) && fits(back, y[k], x[k]);
    return same;
}

// Whether corners are proven once, which takes no other way where it cannot.
bool is_proven_once(const std::shared_ptr<Result>& result, const ProofCase& c) {
    votess::Options options = c.options;
    options.list_walls = true;
    votess::Settled settled = votess::settle(options);
    settled.points.f64 = c.points;
    settled.weights.given = c.weights;
    const votess::CheckedRun run{settled, result->status.size(), result->stats.box_volume};
    const votess::Job job = votess::make_job(std::move(settled));
    return votess::Certificate(run, job, *result, {}).prove_shared().has_value();
}

constexpr std::array names_of_damage{"vertex of a polygon",
                                     "two vertices of two polygons",
                                     "a cell turned inside out",
                                     "vertices of some cells",
                                     "vertices of one cell swapped",
                                     "place of a vertex",
                                     "seed moved",
                                     "all seeds moved",
                                     "weight changed",
                                     "hidden seed",
                                     "shift of a face",
                                     "neighbor of a face",
                                     "two vertices made one",
                                     "list of vertices",
                                     "image of a vertex",
                                     "wall forgotten",
                                     "a polygon shortened",
                                     "two neighbors swapped around a corner",
                                     "all cells turned inside out"};

constexpr std::size_t image_kind = 14;

// Changes a result, or what it is verified with. Returns false where the kind does not apply.
bool damage(std::size_t kind, std::shared_ptr<Result>& r, ProofCase& c, test::Random& random, bool& compares_places) {
    const votess::Rows rows{r->indptr, r->indices, r->shifts};
    const std::size_t n = r->status.size();
    std::size_t i = random.below(n);
    for (std::size_t tries = 0; rows.begin(i) == rows.end(i); ++tries) {
        if (tries > n) return false;
        i = (i + 1) % n;
    }
    const std::size_t e = rows.begin(i) + random.below(rows.end(i) - rows.begin(i));
    const FaceLabel label = rows.label(e);
    const std::size_t behind = label.id < 0 ? rows.end(i) : rows.find(at(label.id), label.seen_from_behind(i));
    const auto faces = polygon(*r, e);
    const std::size_t k = random.below(faces.size()), next = (k + 1) % faces.size();
    const std::int32_t a = faces[k], b = faces[next];
    const auto exchange = [&](std::size_t cell, std::int32_t x, std::int32_t y) {
        for (std::size_t f = rows.begin(cell); f < rows.end(cell); ++f)
            for (std::int32_t& v : polygon(*r, f)) v = v == x ? y : v == y ? x : v;
    };
    const double scale = std::pow(10.0, -random.uniform(0, 7));
    const auto move = [&](std::size_t s) {
        for (std::size_t d = 0; d < 3; ++d) {
            double& x = c.points[3 * s + d];
            x += c.spacing * scale * random.uniform(-1, 1);
            if (c.options.box && c.options.outside == votess::Outside::error)
                x = std::clamp(x, c.options.box->lower[d], std::nextafter(c.options.box->upper[d], -1.0));
        }
    };
    const auto strip_places = [&] {
        r->vertices.resize_uninitialized(0);
        r->cell_vertex_indptr.resize_uninitialized(0);
        r->cell_vertex_indices.resize_uninitialized(0);
        compares_places = false;
    };
    switch (kind) {
        case 0:
            faces[k] = r->face_vertices[random.below(r->face_vertices.size())];
            return true;
        case 1: {
            std::swap(faces[k], faces[next]);
            if (label.id < 0) return true;
            const auto other = polygon(*r, behind);
            for (std::int32_t& v : other) v = v == a ? b : v == b ? a : v;
            return true;
        }
        case 2:
            for (std::size_t f = rows.begin(i); f < rows.end(i); ++f) std::ranges::reverse(polygon(*r, f));
            return true;
        case 3: {  // in all but one of the cells
            std::vector<std::size_t> cells;
            for (std::size_t s = 0; s < n; ++s) {
                bool any = false;
                for (std::size_t f = rows.begin(s); f < rows.end(s); ++f)
                    for (const std::int32_t v : polygon(*r, f)) any |= v == a || v == b;
                if (any) cells.push_back(s);
            }
            if (random.chance(0.7))
                cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(random.below(cells.size())));
            if (random.chance(0.5)) strip_places();
            for (const std::size_t s : cells) exchange(s, a, b);
            return true;
        }
        case 4:
            exchange(i, a, b);
            return true;
        case 5:
            r->vertices[random.below(r->vertices.size())] += c.spacing * std::max(scale, 1e-6);
            return true;
        case 6:
            move(i);
            strip_places();
            return true;
        case 7:
            for (std::size_t s = 0; s < n; ++s) move(s);
            strip_places();
            return true;
        case 8:
            if (c.weights.empty()) return false;
            c.weights[i] += c.spacing * c.spacing * scale * random.uniform(-1, 1);
            strip_places();
            return true;
        case 9: {
            ProofCase other = c;
            if (other.weights.empty()) other.weights.assign(n, 0);
            other.weights[i] -= 100;
            r = copy_of(other.run());
            strip_places();
            return true;
        }
        case 10:
            if (r->shifts.empty() || label.id < 0) return false;
            {
                const std::size_t d = random.below(3);
                const std::int8_t step = random.chance(0.5) ? 1 : -1;
                r->shifts[3 * e + d] = static_cast<std::int8_t>(r->shifts[3 * e + d] + step);
                r->shifts[3 * behind + d] = static_cast<std::int8_t>(r->shifts[3 * behind + d] - step);
            }
            return true;
        case 11: {  // with the same polygons
            if (label.id < 0) return false;
            r->indices[e] = static_cast<std::int32_t>(random.below(n));
            if (random.chance(0.5)) r->indices[behind] = r->indices[e];
            return true;
        }
        case 12:
            if (random.chance(0.5)) strip_places();
            for (std::int32_t& v : std::span<std::int32_t>(r->face_vertices)) v = v == a ? b : v;
            return true;
        case 13:
            r->cell_vertex_indices[random.below(r->cell_vertex_indices.size())] += random.chance(0.5) ? 1 : -1;
            return true;
        case image_kind:
            if (r->vertex_image_of.empty()) return false;
            {
                const std::span<std::int32_t> images = r->vertex_image_of;
                const std::int32_t of_a = images[at(a)], of_b = images[at(b)];
                const std::size_t way = random.below(7);
                if (way == 0) images[at(a)] = b;
                if (way == 1) images[at(a)] = a;
                if (way == 2) std::swap(images[at(a)], images[at(b)]);
                if (way == 3) images[at(of_a)] = of_b;
                if (way == 4) std::ranges::replace(images, of_a, of_b);  // merged
                if (way == 5) images[at(a)] = static_cast<std::int32_t>(random.below(images.size()));
                if (way == 6) r->vertex_shifts[3 * at(a) + random.below(3)] += random.chance(0.5) ? 1 : -1;
                if (way < 6 && random.chance(0.5)) strip_places();
            }
            return true;
        case 15: {
            if (c.options.cell || c.options.periodic != std::array<bool, 3>{}) return false;
            c.options.walls.push_back(
                {{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}, random.uniform(0.2, 1)});
            if (c.options.outside == votess::Outside::error) c.options.outside = votess::Outside::keep;
            strip_places();
            return true;
        }
        case 16: {  // a corner less in two polygons
            const std::int64_t last = r->face_offsets[e + 1] - 1;
            std::rotate(faces.begin() + static_cast<std::ptrdiff_t>(k),
                        faces.begin() + static_cast<std::ptrdiff_t>(k) + 1, faces.end());
            r->face_vertices[at(last)] = faces[0];
            return true;
        }
        case 17: {  // all cells that share the face and its next one name them the other way round
            const std::size_t f = e + 1 < rows.end(i) ? e + 1 : rows.begin(i);
            if (rows.label(f).id < 0 || label.id < 0 || f == e) return false;
            const std::int32_t x = label.id, y = rows.label(f).id;
            for (std::int32_t& id : std::span<std::int32_t>(r->indices)) id = id == x ? y : id == y ? x : id;
            return true;
        }
        default:
            for (std::size_t s = 0; s < n; ++s)
                for (std::size_t f = rows.begin(s); f < rows.end(s); ++f) std::ranges::reverse(polygon(*r, f));
            return true;
    }
}

}  // namespace

TEST_SUITE("cases") {
    // VOTESS_TEST_SETS: the number of sets.
    TEST_CASE("verify proves corners once, and notices each damage of polygons") {
        const char* const given = std::getenv("VOTESS_TEST_SETS");
        const std::size_t sets = given ? std::strtoull(given, nullptr, 10) : test::by_size(54, 18);
        std::array<std::size_t, names_of_damage.size()> noticed{}, harmless{};
        std::size_t proven = 0, once = 0, honest = 0;
        for (std::size_t set = 0; set < sets; ++set) {
            const int domain = static_cast<int>(set % 9);  // of space, with an end
            CAPTURE(set);
            CAPTURE(domain);
            test::Random random(5000 + set);
            ProofCase whole;
            make_case(domain, random, whole);
            whole.options.want = {.neighbors = true, .volumes = random.chance(0.3)};
            whole.options.want.vertices = whole.options.want.faces = true;
            whole.options.want.areas = whole.options.want.counts = random.chance(0.3);
            const votess::Tessellation t = whole.run();
            const votess::VerifyReport good = votess::verify(t, whole.points);
            CHECK(good.failure == "");
            CHECK(good.proven);
            ++honest;
            proven += good.proven;
            const Shape shape = shape_of(votess::detail::result_of(t));
            const bool is_simple = is_proven_once(copy_of(t), whole);
            once += is_simple;
            for (std::size_t kind = 0; kind < names_of_damage.size(); ++kind)
                for (int repeat = 0; repeat < (given ? 3 : 1); ++repeat) {
                    CAPTURE(std::string(names_of_damage[kind]));
                    ProofCase c = whole;
                    auto result = copy_of(t);
                    bool compares_places = true;
                    if (!damage(kind, result, c, random, compares_places)) continue;
                    const auto is_outside = [](votess::CellStatus s) { return s == votess::CellStatus::outside; };
                    if (c.options.outside != votess::Outside::error)  // as verify() sees it
                        c.options.outside = std::ranges::any_of(result->status, is_outside) ? votess::Outside::drop
                                                                                            : votess::Outside::keep;
                    votess::Tessellation truth;
                    try {
                        truth = c.run();
                    } catch (const votess::Error&) {
                        continue;  // a seed has left the domain, or a wall has cut it away
                    }
                    result->walls = c.options.walls;
                    result->weights.resize_uninitialized(c.weights.size());
                    std::ranges::copy(c.weights, result->weights.begin());
                    if (!compares_places)  // nor other numbers
                        votess::detail::for_arrays([&](const auto& array) {
                            using Value = std::remove_cvref_t<decltype(array.of(*result)[0])>;
                            if ((std::is_floating_point_v<Value> && array.name != "weights") ||
                                array.word == &votess::Want::counts)
                                array.of(*result).resize_uninitialized(0);
                        });
                    const Result& right = votess::detail::result_of(truth);
                    bool is_right = std::ranges::equal(right.status, result->status) &&
                                    shape_of(right) == shape_of(*result) && same_vertices(right, *result);
                    // Places and other arrays of the result are as before, and so is what they are compared with.
                    if (compares_places) {
                        const Result& before = votess::detail::result_of(t);
                        votess::detail::for_arrays([&](const auto& array) {
                            if (array.name != "weights")
                                is_right = is_right && std::ranges::equal(array.of(before), array.of(*result));
                        });
                    }
                    // Two vertices that swap their names as originals have the same images.
                    const Result& given_images = votess::detail::result_of(t);
                    if (kind == image_kind)
                        is_right = std::ranges::equal(given_images.vertex_image_of, result->vertex_image_of) &&
                                   std::ranges::equal(given_images.vertex_shifts, result->vertex_shifts);
                    const bool by_corners = is_proven_once(result, c);
                    const votess::VerifyReport report = votess::verify(votess::Tessellation(result), c.points);
                    CAPTURE(report.failure);
                    CAPTURE(report.unproven);
                    if (!is_right) CHECK(!by_corners);
                    ++(is_right ? harmless : noticed)[kind];
                    CHECK(report.passed == is_right);
                    CHECK(report.proven == is_right);
                }
        }
        CHECK(once > sets / 2);
        if (!given) return;
        MESSAGE(honest << " honest sets, " << proven << " proven, " << once << " with corners proven once");
        for (std::size_t kind = 0; kind < names_of_damage.size(); ++kind)
            MESSAGE(std::string(names_of_damage[kind])
                    << ": " << noticed[kind] << " changed, " << harmless[kind] << " did not");
    }

    // Vertices and their images are at places that differ by vectors of the box, and have the same name.
    TEST_CASE("verify notices a cell that names another image of a vertex") {
        std::size_t tried = 0;
        for (std::size_t set = 0; set < test::by_size(12, 6); ++set) {
            CAPTURE(set);
            test::Random random(7000 + set);
            ProofCase c;
            make_case(std::array{1, 2, 3, 7}[set % 4], random, c);
            c.options.want = {.neighbors = true, .volumes = set % 3 == 0};
            c.options.want.vertices = c.options.want.faces = true;
            const votess::Tessellation t = c.run();
            REQUIRE(votess::verify(t, c.points).proven);
            const Result& whole = votess::detail::result_of(t);
            const votess::Rows rows{whole.indptr, whole.indices, whole.shifts};
            for (int repeat = 0; repeat < 12; ++repeat) {
                const std::size_t i = random.below(whole.status.size());
                const auto begin = at(whole.cell_vertex_indptr[i]), end = at(whole.cell_vertex_indptr[i + 1]);
                if (begin == end) continue;
                const std::int32_t v = whole.cell_vertex_indices[begin + random.below(end - begin)];
                std::vector<std::int32_t> others;
                for (std::size_t u = 0; u < whole.vertex_image_of.size(); ++u)
                    if (whole.vertex_image_of[u] == whole.vertex_image_of[at(v)] && u != at(v))
                        others.push_back(static_cast<std::int32_t>(u));
                const auto result = copy_of(t);
                const auto listed = std::span<std::int32_t>(result->cell_vertex_indices).subspan(begin, end - begin);
                std::erase_if(others, [&](std::int32_t u) { return std::ranges::find(listed, u) != listed.end(); });
                if (others.empty()) continue;
                const std::int32_t u = others[random.below(others.size())];
                std::ranges::replace(listed, v, u);
                std::ranges::sort(listed);
                for (std::size_t e = rows.begin(i); e < rows.end(i); ++e)
                    std::ranges::replace(polygon(*result, e), v, u);
                const votess::VerifyReport report = votess::verify(votess::Tessellation(result), c.points);
                CHECK(!report.passed);
                CHECK(!report.proven);
                ++tried;
            }
        }
        CHECK(tried > 20);
    }

    // Its polygons turn the right way everywhere, and those of the ends wind twice. Corner k of the lower end is where
    // sides 2k and 2k + 2 meet.
    TEST_CASE("verify sees a prism over a pentagram") {
        test::Coordinates points{0.5, 0.5, 0.5};
        for (int k = 0; k < 5; ++k)
            points.insert(points.end(), {0.5 + 0.2 * std::cos(0.4 * 3.14159265 * k + 0.1),
                                         0.5 + 0.2 * std::sin(0.4 * 3.14159265 * k + 0.1), 0.5});
        points.insert(points.end(), {0.5, 0.5, 0.7, 0.5, 0.5, 0.3});
        votess::Options options;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        votess::Settled settled = votess::settle(options);
        settled.points.f64 = points;
        const votess::Job job = votess::make_job(std::move(settled));
        const votess::SeedPlanes planes(job);
        for (const int step : {1, 2}) {
            votess::RowPolytope polytope(planes);
            votess::SharedCorners corners(planes, {});
            polytope.begin(0, 0.2);
            for (std::int32_t id = 1; id < 8; ++id) polytope.add({id, {}});
            std::vector<std::int64_t> offsets{0};
            std::vector<std::int32_t> vertices;
            const auto add = [&](std::initializer_list<int> corners_of_face) {
                vertices.insert(vertices.end(), corners_of_face);
                offsets.push_back(static_cast<std::int64_t>(vertices.size()));
            };
            std::array<int, 5> after{};  // by side: the corner where it meets the next one, above; 5 more: below
            for (int k = 0; k < 5; ++k) after[at(step * k % 5)] = k;
            for (int side = 0; side < 5; ++side) {
                const int high = after[at(side)], before = (high + 4) % 5;
                add({before, 5 + before, 5 + high, high});
            }
            add({0, 1, 2, 3, 4});
            add({9, 8, 7, 6, 5});
            REQUIRE(polytope.close_polygons(offsets, vertices, {}));
            polytope.begin_corners();
            CHECK(corners.add(polytope, 0) == (step == 1));
        }
    }
}
