// verify(): how many cells it tries, and that it finds results that are wrong in one place.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>

#include "input/settle.hpp"
#include "result/handle.hpp"
#include "result/result.hpp"
#include "result/rows.hpp"
#include "support/arrays.hpp"
#include "support/check.hpp"
#include "support/proof_case.hpp"
#include "support/random.hpp"
#include "support/scattered.hpp"
#include "verify/certificate.hpp"
#include "verify/row_checker.hpp"

namespace {

using test::make_case;
using test::proof_domains;
using test::ProofCase;
using votess::FaceLabel;

// The rows of a result as lists that can be changed.
struct Parts {
    std::vector<std::vector<FaceLabel>> rows;
    std::vector<votess::CellStatus> status;
};

Parts parts_of(const votess::Tessellation& t) {
    const votess::Rows rows{t.indptr(), t.indices(), t.shifts()};
    Parts parts{std::vector<std::vector<FaceLabel>>(t.size()), {t.status().begin(), t.status().end()}};
    for (std::size_t i = 0; i < t.size(); ++i)
        for (std::size_t entry = rows.begin(i); entry < rows.end(i); ++entry)
            parts.rows[i].push_back(rows.label(entry));
    return parts;
}

template <class To, class From>
void copy(To& to, const From& from) {
    to.resize_uninitialized(from.size());
    std::ranges::copy(from, to.begin());
}

// Returns a result with the same domain and no arrays.
std::shared_ptr<votess::detail::Result> domain_of(const votess::Tessellation& t) {
    auto result = std::make_shared<votess::detail::Result>();
    result->box = t.box();
    result->periodic = t.periodic();
    result->cell = t.cell();
    result->walls.assign(t.walls().begin(), t.walls().end());
    result->planar = t.planar();
    copy(result->weights, t.weights());
    copy(result->duplicate_of, t.duplicate_of());
    result->lists_walls = t.lists_walls();
    result->stats = t.stats();
    return result;
}

// Makes a result one of some seeds. all: of all of them.
void make_subset(votess::detail::Result& result, const votess::Tessellation& t, const votess::Tessellation& all) {
    result.is_subset = true;
    copy(result.ids, t.ids());
    votess::detail::AllSeeds seeds;
    seeds.count = all.size();
    seeds.status.assign(all.status().begin(), all.status().end());
    seeds.weights.assign(all.weights().begin(), all.weights().end());
    result.all_seeds = std::make_shared<votess::detail::AllSeeds>(std::move(seeds));
}

// Returns some of these numbers, in any order.
std::vector<std::int64_t> some_ids(std::size_t count, test::Random& random) {
    std::vector<std::int64_t> ids;
    for (const std::size_t i : test::permutation(count, random))
        if (random.chance(0.4)) ids.push_back(static_cast<std::int64_t>(i));
    return ids;
}

// Returns the result with these rows and statuses, and without volumes, so that only rows can be wrong.
std::shared_ptr<votess::detail::Result> result_with_parts(const votess::Tessellation& t, const Parts& parts) {
    auto result = domain_of(t);
    std::vector<std::int64_t> indptr{0};
    std::vector<std::int32_t> indices;
    std::vector<std::int8_t> shifts;
    for (const auto& row : parts.rows) {
        for (const FaceLabel& label : row) {
            indices.push_back(label.id);
            if (!t.shifts().empty()) shifts.insert(shifts.end(), label.shift.begin(), label.shift.end());
        }
        indptr.push_back(static_cast<std::int64_t>(indices.size()));
    }
    copy(result->indptr, indptr);
    copy(result->indices, indices);
    copy(result->shifts, shifts);
    copy(result->status, parts.status);
    return result;
}
votess::Tessellation with_parts(const votess::Tessellation& t, const Parts& parts) {
    return votess::Tessellation(result_with_parts(t, parts));
}

votess::Options rows_only() {
    votess::Options options = test::all_options();
    options.want = {true, false, false, false};
    options.list_walls = false;
    return options;
}

votess::Options periodic_options(int domain) {
    votess::Options options = rows_only();
    if (domain == 0) {
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.periodic = {true, true, true};
    } else if (domain == 1) {
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        options.periodic = {false, true, false};
    } else {
        options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.7, 0.8}};
    }
    return options;
}

void insert(std::vector<FaceLabel>& row, const FaceLabel& label) {
    const auto at = std::ranges::lower_bound(row, label);
    if (at == row.end() || *at != label) row.insert(at, label);
}
void remove_face(Parts& parts, std::size_t i, const FaceLabel& label) {
    std::erase(parts.rows[i], label);
    if (label.id >= 0) std::erase(parts.rows[static_cast<std::size_t>(label.id)], label.seen_from_behind(i));
}
void add_face(Parts& parts, std::size_t i, const FaceLabel& label) {
    insert(parts.rows[i], label);
    insert(parts.rows[static_cast<std::size_t>(label.id)], label.seen_from_behind(i));
}

constexpr int kinds_of_damage = 12;

// Changes the parts of a result, or the points, weights or domain that it is verified with. Returns false where the
// kind does not apply.
bool damage(int kind, Parts& parts, ProofCase& c, test::Random& random) {
    const std::size_t n = parts.rows.size(), dimensions = c.options.planar ? 2 : 3;
    const std::size_t i = random.below(n);
    auto& row = parts.rows[i];
    const auto any = [&]() -> FaceLabel { return row[random.below(row.size())]; };
    const auto move = [&](std::size_t s, double step) {
        for (std::size_t k = 0; k < dimensions; ++k) {
            double& x = c.points[dimensions * s + k];
            x += step * random.uniform(-1, 1);
            if (c.options.box && c.options.outside == votess::Outside::error)
                x = std::clamp(x, c.options.box->lower[k], std::nextafter(c.options.box->upper[k], -1.0));
        }
    };
    const double scale = std::pow(10.0, -random.uniform(0, 7));
    FaceLabel label;
    if (kind < 5) {
        if (row.empty()) return false;
        label = any();
        if (label.id < 0 && kind > 0) return false;
    }
    switch (kind) {
        case 0:
            std::erase(row, label);
            return true;
        case 1:
            remove_face(parts, i, label);
            return true;
        case 2:
        case 3: {
            FaceLabel other = label;
            other.id = static_cast<std::int32_t>(random.below(n));
            if (other.id == static_cast<std::int32_t>(i)) return false;
            if (kind == 2) remove_face(parts, i, label);
            add_face(parts, i, other);
            return true;
        }
        case 4: {
            if (c.options.periodic == std::array<bool, 3>{} && !c.options.cell) return false;
            FaceLabel other = label;
            other.shift[random.below(3)] += random.chance(0.5) ? 1 : -1;
            remove_face(parts, i, label);
            if (other == FaceLabel{static_cast<std::int32_t>(i), {}}) return true;
            add_face(parts, i, other);
            return true;
        }
        case 5: {
            while (!row.empty()) remove_face(parts, i, FaceLabel(row.back()));
            parts.status[i] = votess::CellStatus::empty;
            return true;
        }
        case 6:
            parts.status[i] = votess::CellStatus::certified;
            return true;
        case 7:
            move(i, c.spacing * scale);
            return true;
        case 8:
            if (c.weights.empty()) return false;
            c.weights[i] += c.spacing * c.spacing * scale * random.uniform(-1, 1);
            return true;
        case 9: {  // rows as if a seed were hidden
            ProofCase other = c;
            if (other.weights.empty()) other.weights.assign(n, 0);
            other.weights[i] -= 100;
            parts = parts_of(other.run());
            return true;
        }
        case 10:
            if (c.options.cell || c.options.periodic != std::array<bool, 3>{} || c.options.planar) return false;
            if (!c.options.box || std::isinf(c.options.box->upper[0])) return false;
            c.options.walls.push_back(
                {{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}, random.uniform(0.2, 1)});
            if (c.options.outside == votess::Outside::error) c.options.outside = votess::Outside::keep;
            return true;
        default:
            for (std::size_t s = 0; s < n; ++s) move(s, c.spacing * scale);
            return true;
    }
}

// Returns the result of an engine with another precision, whose volumes are all larger by this factor.
votess::Tessellation with_error(const votess::Tessellation& t, votess::Precision precision, double factor) {
    auto result = domain_of(t);
    copy(result->indptr, t.indptr());
    copy(result->indices, t.indices());
    copy(result->status, t.status());
    copy(result->volumes, t.volumes());
    for (double& volume : result->volumes) volume *= factor;
    result->stats.volume_sum *= factor;
    result->stats.precision = precision;
    return votess::Tessellation(std::move(result));
}

// Returns what the certificate alone says of rows.
votess::Certificate::Verdict certificate_of(const votess::Tessellation& t, const ProofCase& c) {
    votess::Settled settled = votess::settle(c.options);
    settled.points.f64 = c.points;
    settled.weights.given = c.weights;
    const votess::CheckedRun run{settled, t.size(), t.stats().box_volume};
    const votess::Job job = votess::make_job(std::move(settled));
    return votess::Certificate(run, job, votess::detail::result_of(t), {}).prove();
}

// All seeds in one block.
struct OneBlock : votess::RunBlocks {
    explicit OneBlock(const test::PointSet& some) : set(some) {}
    void for_blocks(const std::function<void(votess::Seeds)>& task) override {
        votess::Seeds seeds;
        for (std::size_t i = 0; i < set.size(); ++i) seeds.add(static_cast<std::int64_t>(i), set.points, {}, i);
        task(seeds);
    }
    const test::PointSet& set;
};

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("verify says how many cells it tried") {
        const test::PointSet set = test::uniform(400, 97);
        const auto t = test::run(set);
        CHECK(votess::verify(t, set.points).sampled == 0);
        CHECK(votess::verify(t, set.points).proven);
        CHECK(votess::verify(t, set.points, {10, 1}).sampled == 10);
        CHECK(votess::verify(t, set.points, {0, 1}).sampled == 0);
        CHECK(votess::verify(t, set.points, {401, 1}).sampled == 400);
        CHECK_FALSE(votess::verify(t, set.points, {401, 1}).proven);
        for (std::size_t few = 1; few <= 9; ++few) {  // than a round holds
            const test::PointSet seeds = test::uniform(few, 110 + few);
            CHECK(votess::verify(test::run(seeds), seeds.points, {few, 1}).sampled == few);
        }

        test::Coordinates moved = set.points;  // seen by the sample alone
        moved[3 * 200] += moved[3 * 200] < 0.5 ? 0.05 : -0.05;
        const auto failed = votess::verify(t, moved);
        CHECK_FALSE(failed.passed);
        CHECK(failed.sampled > 0);
        CHECK(failed.sampled < 400);

        votess::Options nothing = rows_only();
        nothing.want = {false, false, false, false};
        CHECK(votess::verify(test::run(set, nothing), set.points).sampled == 0);
    }

    // The number does not come from a clock.
    TEST_CASE("a checker of rows tries as many cells as its budget pays for, each time the same number") {
        votess::Options options = rows_only();
        options.want = {false, true, false, false};
        const test::PointSet large = test::uniform(test::by_size(50000, 500), 99);
        const auto t = test::run(large, options);
        options.box = large.box;
        votess::BlockCells cells;
        cells.status.assign(t.status().begin(), t.status().end());
        cells.volumes.assign(t.volumes().begin(), t.volumes().end());
        const auto sampled = [&](double budget) {
            OneBlock block(large);
            const votess::RowChecker::Sample sample{.max_cells = large.size(), .budget = budget};
            votess::RowChecker checker({votess::settle(options), large.size(), t.stats().box_volume}, sample, block);
            checker.take(votess::rows_of(cells));
            const votess::VerifyReport report = checker.report();
            CHECK(report.passed);
            CHECK_FALSE(report.proven);
            return report.sampled;
        };
        const std::size_t many = sampled(votess::sample_budget / 4), few = sampled(votess::sample_budget / 20);
        CHECK(few >= votess::min_sample);
        CHECK(few <= many);
        if (!test::reduced()) CHECK(few < many);
        if (!test::reduced()) CHECK(many < large.size() / 10);
        CHECK(sampled(votess::sample_budget / 20) == few);
    }

    // In periodic domains the neighbors are images, found only where verify looks at all that reach the cell.
    TEST_CASE("verify sees each face that two rows lack, images too") {
        for (int domain = 0; domain < 3; ++domain)
            for (const std::size_t n : {1, 2, 5, 8})
                for (const bool weighted : {false, true}) {
                    if (test::reduced() && (n > 5 || (n == 5 && weighted))) continue;
                    CAPTURE(domain);
                    CAPTURE(n);
                    CAPTURE(weighted);
                    test::Random random(100 + n);
                    test::Coordinates points;
                    std::vector<double> weights;
                    for (std::size_t i = 0; i < n; ++i) {
                        for (int k = 0; k < 3; ++k) points.push_back(random.uniform(0, 1));
                        if (weighted) weights.push_back(random.uniform(0, 0.05));
                    }
                    votess::Options options = periodic_options(domain);
                    options.weights = weights;
                    options.outside = votess::Outside::drop;
                    const auto t = votess::tessellate(std::span<const double>(points), options);
                    const Parts whole = parts_of(t);
                    const auto with_whole = with_parts(t, whole);
                    CHECK(votess::verify(with_whole, points).failure == "");
                    std::size_t removed = 0;
                    for (std::size_t i = 0; i < t.size(); ++i)
                        for (const FaceLabel& label : whole.rows[i]) {
                            Parts parts = whole;
                            std::erase(parts.rows[i], label);
                            std::erase(parts.rows[static_cast<std::size_t>(label.id)], label.seen_from_behind(i));
                            const auto report = votess::verify(with_parts(t, parts), points, {n, 1});
                            CHECK(report.failure.find("by trying every seed") != std::string::npos);
                            ++removed;
                        }
                    CHECK(removed == t.indices().size());
                    CHECK(removed > 0);
                }
    }

    TEST_CASE("verify names a seed that does not list its neighbor") {
        const test::PointSet set = test::uniform(300, 105);
        for (int domain = 0; domain < 3; ++domain) {
            const auto t = votess::tessellate(std::span<const double>(set.points), periodic_options(domain));
            Parts parts = parts_of(t);
            const FaceLabel label = parts.rows[77][3];
            std::erase(parts.rows[static_cast<std::size_t>(label.id)], label.seen_from_behind(77));
            CHECK(votess::verify(with_parts(t, parts), set.points, {0, 1}).failure ==
                  "seed 77 lists " + std::to_string(label.id) + ", which does not list it");
        }
    }

    TEST_CASE("verify sees polygons that are open or differ, and a surface that is not closed") {
        const test::PointSet set = test::uniform(60, 106);
        votess::Options options = test::all_options();
        options.want.faces = options.want.normals = true;
        const auto t = test::run(set, options);
        std::vector<std::int32_t> corners(t.face_vertices().begin(), t.face_vertices().end());
        std::vector<double> normals(t.face_normals().begin(), t.face_normals().end());
        const auto failure = [&] {
            auto result = domain_of(t);
            copy(result->status, t.status());
            copy(result->indptr, t.indptr());
            copy(result->indices, t.indices());
            copy(result->face_areas, t.face_areas());
            copy(result->face_normals, normals);
            copy(result->face_offsets, t.face_offsets());
            copy(result->face_vertices, corners);
            return votess::verify(votess::Tessellation(std::move(result)), set.points).failure;
        };
        CHECK(failure() == "");
        const auto row = static_cast<std::size_t>(t.indptr()[17]), end = static_cast<std::size_t>(t.indptr()[18]);
        normals[3 * row] += 0.01;
        CHECK(failure().starts_with("cell 17 is not closed: area times normal sums to "));
        normals[3 * row] -= 0.01;
        const auto first = static_cast<std::size_t>(t.face_offsets()[end - 1]);  // of a neighbor above 17
        REQUIRE(t.indices()[end - 1] > 17);
        std::swap(corners[first], corners[first + 1]);
        CHECK(failure() == "cell 17 is not watertight");
        std::swap(corners[first], corners[first + 1]);
        // Two vertices of one cell are exchanged: it is closed, but its neighbors have other polygons.
        const std::int32_t a = corners[first], b = corners[first + 1];
        for (auto k = static_cast<std::size_t>(t.face_offsets()[row]);
             k < static_cast<std::size_t>(t.face_offsets()[end]); ++k)
            corners[k] = corners[k] == a ? b : corners[k] == b ? a : corners[k];
        CHECK(failure().ends_with(" have different polygons between them"));
    }

    // Each number of a result of the plane, or of a domain without end, is changed.
    TEST_CASE("verify sees wrong numbers in the plane and in a domain without end") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        test::Coordinates in_plane;
        test::Random random(107);
        for (std::size_t i = 0; i < 24; ++i) in_plane.push_back(random.uniform(0, 1));
        const auto in_space = test::uniform(12, 108).points;
        for (std::size_t kind = 0; kind < 10; kind += test::by_size(1, 3)) {
            CAPTURE(kind);
            const std::size_t domain = kind % 5;
            const bool is_subset = kind >= 5;
            votess::Options options;
            options.device = "cpu";
            options.planar = domain < 3;
            options.list_walls = domain % 2 == 0;
            options.want = {.neighbors = true, .volumes = true, .counts = true, .areas = true, .normals = true};
            const double side = domain < 2 ? 1 : inf;
            if (domain < 2) options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
            if (domain == 1) options.periodic = {true, true, false};
            if (domain == 2) options.box = votess::Box{{-inf, -inf, 0}, {inf, inf, 0}};
            if (domain > 2) options.box = test::cube(-side, side);
            if (domain == 4) options.box->lower[2] = 0;
            const test::Coordinates& points = domain < 3 ? in_plane : in_space;
            const auto all = votess::tessellate(std::span<const double>(points), options);
            const std::vector<std::int64_t> ids = some_ids(all.size(), random);
            if (is_subset) options.only = ids;
            const auto t = votess::tessellate(std::span<const double>(points), options);
            const auto passes = [&](const auto& change) {
                auto result = domain_of(t);
                result->planar = t.planar();
                if (is_subset) make_subset(*result, t, all);
                test::copy_arrays(t, *result);
                change(*result);
                return votess::verify(votess::Tessellation(std::move(result)), points, {3, 1}).passed;
            };
            using Result = votess::detail::Result;
            CHECK(passes([](const Result&) {}));
            std::size_t seen = 0, tried = 0;
            const auto change_some = [&](auto member) {
                std::size_t count = 0;
                (void)passes([&](const Result& r) { count = (r.*member).size(); });
                for (std::size_t k = 0; k < count; k += 1 + count / 5) {
                    ++tried;
                    seen += !passes([&](Result& r) {
                        auto& value = (r.*member)[k];
                        value = std::isfinite(static_cast<double>(value)) ? value + 1 : 1;
                    });
                }
            };
            change_some(&Result::shifts);
            change_some(&Result::face_areas);
            change_some(&Result::face_normals);
            change_some(&Result::volumes);
            change_some(&Result::face_counts);
            change_some(&Result::edge_counts);
            change_some(&Result::vertex_counts);
            CHECK(seen == tried);
            CHECK(tried > (is_subset ? 8 : 20));
        }
    }

    // Every other seed lies outside, is kept or dropped, and some are duplicates.
    TEST_CASE("verify of some cells sees each lost face, wrong volume and wrong status") {
        test::Random random(109);
        test::Scattered s;
        for (int kind = 0; kind < test::kinds_of_scattered; ++kind)
            for (const bool weighted : {false, true}) {
                CAPTURE(kind);
                CAPTURE(weighted);
                test::scatter(kind, 120, 0.2, weighted, 110, s);
                for (std::size_t k = 0; k < 3 * 5; ++k) s.points[360 - 15 + k] = s.points[k];
                s.options.want = {.neighbors = true, .volumes = true};
                if (random.chance(0.5)) s.options.outside = votess::Outside::drop;
                const auto all = votess::tessellate(s.points, s.options);
                const std::vector<std::int64_t> ids = some_ids(all.size(), random);
                s.options.only = ids;
                const auto t = votess::tessellate(s.points, s.options);
                const votess::VerifyReport report = votess::verify(t, s.points);
                CHECK(report.failure == "");
                CHECK(report.proven);
                if (report.sampled > 0) {  // else a run of all cells was compared
                    CHECK(report.skipped == std::vector<std::string>{"volumes", "euler"});
                    CHECK(report.sampled > ids.size() / 4);
                }
                CHECK(!report.tiny_faces);
                const auto passes = [&](const votess::Tessellation& changed, const auto& change) {
                    auto result = domain_of(changed);
                    copy(result->indptr, changed.indptr());
                    copy(result->indices, changed.indices());
                    copy(result->shifts, changed.shifts());
                    copy(result->status, changed.status());
                    copy(result->volumes, t.volumes());
                    result->walls.assign(t.walls().begin(), t.walls().end());
                    make_subset(*result, t, all);
                    change(*result);
                    return votess::verify(votess::Tessellation(std::move(result)), s.points).passed;
                };
                CHECK(passes(t, [](const auto&) {}));
                for (const std::int32_t id : {-1, std::numeric_limits<std::int32_t>::max()})
                    CHECK(!passes(t, [&](auto& r) { r.ids[0] = id; }));
                if (weighted) CHECK(!passes(t, [](auto& r) { r.weights[r.weights.size() / 2] += 1; }));
                std::size_t tried = 0;
                for (std::size_t k = 0; k < ids.size() && tried < 4; ++k) {
                    if (t.status()[k] != votess::CellStatus::certified) continue;
                    ++tried;
                    CAPTURE(k);
                    CHECK(!passes(t, [&](auto& r) { r.volumes[k] *= 1.001; }));
                    CHECK(!passes(t, [&](auto& r) { r.status[k] = votess::CellStatus::empty; }));
                    Parts parts = parts_of(t);
                    parts.rows[k].erase(parts.rows[k].begin() + static_cast<std::ptrdiff_t>(k % parts.rows[k].size()));
                    CHECK(!passes(with_parts(t, parts), [](const auto&) {}));
                }
                CHECK(tried >= 3);
            }
    }

    TEST_CASE("verify compares each cell of a tight cluster with its own size") {
        test::Random random(119);
        test::Coordinates points;
        for (int i = 0; i < 600; ++i) points.push_back(0.5 + 1e-6 * random.uniform());
        for (const bool drops : {false, true}) {
            votess::Options options;
            options.device = "cpu";
            options.box = test::unit_box();
            options.want = {.neighbors = drops, .volumes = true, .surfaces = true};
            options.min_area = drops ? 1e-15 : 0;
            const auto t = votess::tessellate(std::span<const double>(points), options);
            CHECK(votess::verify(t, points).proven);
            std::size_t smallest = 0;
            for (std::size_t i = 0; i < t.size(); ++i)
                if (t.volumes()[i] < t.volumes()[smallest]) smallest = i;
            for (const auto values : {t.volumes(), t.surface_areas()}) {
                double& value = const_cast<double&>(values[smallest]);
                const double right = value;
                value *= 1.001;
                CHECK_FALSE(votess::verify(t, points).passed);
                value = right;
            }
        }
    }

    // Needles, slabs and dots. Sums of areas and heights lose all digits of some volumes.
    TEST_CASE("verify proves cells of any shape, and sees each wrong size of one") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        test::Random random(120);
        std::size_t tried = 0;
        for (std::size_t set = 0; set < test::by_size(10, 5); ++set)
            for (const int want : {0, 1, 2}) {
                CAPTURE(set);
                CAPTURE(want);
                votess::Options options;
                options.device = "cpu";
                options.threads = 1;
                options.box = test::unit_box();
                options.want = {.neighbors = want > 0, .volumes = true, .surfaces = want == 2};
                options.want.centroids = options.want.areas = options.want.vertices = options.want.faces = want == 2;
                if (want == 1) options.min_area = 1e-60;
                test::Coordinates points;
                const auto add = [&](std::int64_t most, double unit, const std::array<double, 3>& scale) {
                    for (double s : scale)
                        points.push_back(0.5 + s * unit * static_cast<double>(random.integer(-most, most)));
                };
                const std::size_t kind = set % 5;
                if (kind == 0)  // numbers that were float32
                    for (int i = 0; i < 30; ++i) add(8, 0x1p-24, {1, 1, 1});
                if (kind == 1)
                    for (int i = 0; i < 4; ++i) add(8192, 0x1p-40, {1, 1, 1});
                if (kind == 2) {
                    options.box = votess::Box{{0, 0, 0}, {1, 1e-8, 1e-8}};
                    for (int i = 0; i < 5; ++i)
                        for (const double side : options.box->upper) points.push_back(side * random.uniform());
                }
                if (kind == 3)
                    for (int i = 0; i < 9; ++i) add(64, 0x1p-30, {0x1p22, 1, 1});
                if (kind == 4) {
                    options.box = test::cube(-inf, inf);
                    for (const double x : test::cubic(4).points)
                        points.push_back(x + 0x1p-52 * static_cast<double>(random.integer(-2, 2)));
                    options.want.areas = false;
                }
                const auto t = votess::tessellate(std::span<const double>(points), options);
                const auto report = votess::verify(t, points);
                CHECK(report.failure == "");
                CHECK(report.proven);
                // Changes the largest component of some vectors.
                const auto change = [&](const std::string& name, std::span<const double> values,
                                        std::size_t components) {
                    CAPTURE(name);
                    for (int k = 0; k < 3 && !values.empty(); ++k) {
                        const auto begin = components * random.below(values.size() / components);
                        const auto vector = values.subspan(begin, components);
                        const auto largest = std::ranges::max_element(
                            vector, {}, [](double x) { return std::isfinite(x) ? std::abs(x) : -1; });
                        double& value = const_cast<double&>(*largest);
                        const double right = value;
                        if (!std::isfinite(right) || right == 0) continue;
                        if (components == 3 && std::abs(right) < 1e-6) continue;  // next to the origin
                        value *= k == 0 ? -1 : 1.001;
                        CHECK_FALSE(votess::verify(t, points).passed);
                        value = right;
                        ++tried;
                    }
                };
                change("volumes", t.volumes(), 1);
                change("surface_areas", t.surface_areas(), 1);
                change("centroids", t.centroids(), 3);
                change("vertices", t.vertices(), 3);
            }
        CHECK(tried > test::by_size(100, 50));
    }

    TEST_CASE("verify sees that none of some seeds, all outside, has a cell") {
        const test::PointSet set = test::uniform(30, 118);
        votess::Options options;
        options.device = "cpu";
        options.box = test::cube(0.25, 0.75);
        options.outside = votess::Outside::drop;
        options.want = {.neighbors = true, .volumes = false};
        std::vector<std::int64_t> ids;
        for (std::size_t i = 0; i < set.size() && ids.size() < 3; ++i)
            if (set.points[3 * i] < 0.25) ids.push_back(static_cast<std::int64_t>(i));
        options.only = ids;
        const auto t = votess::tessellate(std::span<const double>(set.points), options);
        CHECK(votess::verify(t, set.points).failure == "");
        auto& status = const_cast<votess::CellStatus&>(t.status()[0]);
        for (const auto wrong : {votess::CellStatus::empty, votess::CellStatus::certified}) {
            status = wrong;
            CHECK_FALSE(votess::verify(t, set.points).passed);
        }
    }

    TEST_CASE("verify passes results without cells") {
        CHECK(votess::verify(votess::Tessellation(), {}).passed);
        CHECK(votess::count_tiny_faces(votess::Tessellation(), {}) == 0);
        votess::Options options;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        CHECK(votess::verify(votess::tessellate(std::span<const double>(), options), {}).passed);
        CHECK_THROWS_AS((void)votess::verify(votess::Tessellation(), std::vector<double>{1, 2, 3}), votess::Error);
    }

    TEST_CASE("verify sees a face that two rows list twice, and a row out of order") {
        const test::PointSet set = test::uniform(200, 101);
        const auto t = test::run(set, rows_only());
        const Parts whole = parts_of(t);
        REQUIRE(votess::verify(with_parts(t, whole), set.points).failure == "");
        Parts twice = whole;
        const FaceLabel label = whole.rows[7][2];
        auto& behind = twice.rows[static_cast<std::size_t>(label.id)];
        twice.rows[7].insert(twice.rows[7].begin() + 2, label);
        behind.insert(std::ranges::find(behind, label.seen_from_behind(7)), label.seen_from_behind(7));
        CHECK(votess::verify(with_parts(t, twice), set.points, {0, 1}).failure.find("does not ascend") !=
              std::string::npos);
        Parts disordered = whole;
        std::swap(disordered.rows[0][0], disordered.rows[0][1]);
        CHECK(votess::verify(with_parts(t, disordered), set.points, {0, 1}).failure ==
              "the row of seed 0 does not ascend at " + std::to_string(disordered.rows[0][1].id));
    }

    TEST_CASE("verify sees a cell that is said to be empty, and an empty one that is said to be none") {
        const test::PointSet set = test::uniform(100, 102);
        votess::Options options = rows_only();
        std::vector<double> weights(set.size());
        weights[13] = 0.09;  // buries its neighbors
        options.weights = weights;
        const auto t = test::run(set, options);
        const Parts whole = parts_of(t);
        const auto empty = std::ranges::find(whole.status, votess::CellStatus::empty);
        REQUIRE(empty != whole.status.end());
        CHECK(votess::verify(with_parts(t, whole), set.points).failure == "");
        Parts parts = whole;
        parts.status[static_cast<std::size_t>(empty - whole.status.begin())] = votess::CellStatus::certified;
        CHECK(votess::verify(with_parts(t, parts), set.points, {100, 1}).failure.find("is reported to have a cell") !=
              std::string::npos);
        parts = whole;
        parts.status[13] = votess::CellStatus::empty;
        CHECK(votess::verify(with_parts(t, parts), set.points, {100, 1}).failure ==
              "seed 13 is reported to have no cell, trying every seed leaves one");
    }

    TEST_CASE("verify passes a good result and fails on points that do not belong") {
        const test::PointSet set = test::uniform(400, 93), other = test::uniform(400, 94);
        const auto t = test::run(set);
        CHECK(votess::verify(t, set.points).passed);
        CHECK(votess::verify(t, set.points, {400, 7}).passed);
        const auto report = votess::verify(t, other.points);
        CHECK_FALSE(report.passed);
        CHECK(report.failure != "");
        CHECK(report.failure.find('\n') == std::string::npos);
        CHECK_THROWS_AS((void)votess::verify(t, std::span(set.points).first(3 * 399)), votess::Error);
        CHECK_THROWS_AS((void)votess::verify(t, std::span(set.points).first(3 * 400 - 1)), votess::Error);

        // One seed moved a little: only the sample can see it, and must when it takes every cell.
        test::Coordinates moved = set.points;
        moved[3 * 200] += moved[3 * 200] < 0.5 ? 0.05 : -0.05;
        CHECK_FALSE(votess::verify(t, moved, {400, 1}).passed);
    }

    TEST_CASE("verify allows the errors of the precision, no more") {
        const test::PointSet set = test::uniform(400, 96);
        votess::Options options;
        options.device = "cpu";
        options.box = set.box;
        const auto t = votess::tessellate(set.points, options);
        CHECK(t.stats().precision == votess::Precision::double_);
        const auto passes = [&](votess::Precision precision, double error, std::size_t sample) {
            return votess::verify(with_error(t, precision, 1 + error), set.points, {sample, 1}).passed;
        };
        using enum votess::Precision;
        for (const double sign : {1.0, -1.0}) {
            CHECK(passes(double_, sign * 1e-11, 400));
            CHECK_FALSE(passes(double_, sign * 5e-10, 400));  // cells
            CHECK(passes(double_, sign * 5e-10, 0));
            CHECK_FALSE(passes(double_, sign * 2e-9, 0));  // sum
            CHECK(passes(single, sign * 9e-6, 400));
            CHECK_FALSE(passes(single, sign * 2e-5, 400));
            CHECK(passes(single, sign * 9e-5, 0));
            CHECK_FALSE(passes(single, sign * 2e-4, 0));
        }
    }

    // VOTESS_TEST_SETS: the number of sets.
    TEST_CASE("verify proves results, and notices what changes the diagram, and nothing else") {
        const char* const given = std::getenv("VOTESS_TEST_SETS");
        const std::size_t sets = given ? std::strtoull(given, nullptr, 10) : test::by_size(110, 22);
        std::array<std::size_t, kinds_of_damage> changed{}, harmless{};
        for (std::size_t set = 0; set < sets; ++set) {
            const int domain = static_cast<int>(set % proof_domains);
            CAPTURE(set);
            CAPTURE(domain);
            test::Random random(1000 + set);
            ProofCase whole;
            make_case(domain, random, whole);
            const votess::Tessellation t = whole.run();
            const Parts parts = parts_of(t);
            const votess::VerifyReport good = votess::verify(with_parts(t, parts), whole.points);
            CHECK(good.failure == "");
            CHECK(good.proven);
            for (int kind = 0; kind < kinds_of_damage; ++kind) {
                CAPTURE(kind);
                ProofCase c = whole;
                Parts damaged = parts;
                if (!damage(kind, damaged, c, random)) continue;
                if (c.options.outside != votess::Outside::error)  // as verify() sees it
                    c.options.outside =
                        std::ranges::find(damaged.status, votess::CellStatus::outside) != damaged.status.end()
                            ? votess::Outside::drop
                            : votess::Outside::keep;
                votess::Tessellation truth;
                try {
                    truth = c.run();
                } catch (const votess::Error&) {
                    continue;  // a seed has left the domain, or a wall has cut it away
                }
                const Parts right = parts_of(truth);
                const bool is_right = right.rows == damaged.rows && right.status == damaged.status;
                auto result = result_with_parts(t, damaged);
                result->walls = c.options.walls;
                copy(result->weights, c.weights);
                const auto report = votess::verify(votess::Tessellation(std::move(result)), c.points);
                CAPTURE(report.failure);
                CHECK(report.passed == is_right);
                CHECK(report.proven == is_right);
                ++(is_right ? harmless : changed)[static_cast<std::size_t>(kind)];
            }
        }
        if (given)
            for (std::size_t kind = 0; kind < changed.size(); ++kind)
                MESSAGE("kind " << kind << ": " << changed[kind] << " changed, " << harmless[kind] << " did not");
    }

    TEST_CASE("verify sees each number that changes, in every array and domain") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        const test::Coordinates vertices{0, 0, 0, 1.2, 0, 0, 0, 1.2, 0, 0, 0, 1.2};
        const std::vector<std::int32_t> triangles{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
        test::Random random(110);
        std::size_t tried = 0;
        constexpr std::size_t domains = 10;
        for (std::size_t kind = 0; kind < 2 * domains; kind += test::by_size(1, 3)) {
            const std::size_t domain = kind % domains;
            CAPTURE(kind);
            votess::Options options;
            if (kind >= domains && (domain == 6 || domain == 9)) continue;  // small faces need all cells
            if (kind >= domains) options.min_area = 0.01;
            options.device = "cpu";
            options.threads = 1;
            options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = true, .surfaces = true};
            if (domain != 5) options.want.counts = options.want.normals = options.want.radii = true;
            if (domain != 5 && kind != domains + 1) options.want.vertices = options.want.faces = true;
            options.planar = domain == 4;
            options.list_walls = random.chance(0.5);
            if (domain != 5 && domain != 7) options.box = domain == 3 ? test::cube(-inf, inf) : test::unit_box();
            if (domain == 4) options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
            if (domain == 1 || domain == 9) options.periodic = {true, true, true};
            if (domain == 5) options.mesh = votess::TriangleMesh{vertices, triangles};
            if (domain == 7) options.cell = votess::TriclinicBox{{0, 0, 0}, {1, 0, 0}, {0.4, 1, 0}, {-0.3, 0.7, 0.8}};
            test::Coordinates points = test::uniform(domain == 9 ? 70 : 20, 111).points;
            std::vector<double> weights(20);
            for (double& weight : weights) weight = random.uniform(0, 0.05);
            if (domain == 2) options.weights = weights;
            if (domain == 4) points.resize(40);
            if (domain == 0 || domain == 2) std::copy_n(points.begin(), 3, points.begin() + 3);  // a duplicate
            if (domain == 8) {
                options.outside = votess::Outside::drop;
                points[9] = 1.5;
            }
            std::vector<std::int64_t> ids{1, 4, 5, 12};  // few, or so many that a run of all cells costs less
            for (std::int64_t id = 69; id > 12 && domain == 9; --id) ids.push_back(id);
            if (domain == 6 || domain == 9) options.only = ids;
            const auto t = votess::tessellate(std::span<const double>(points), options);
            REQUIRE(votess::verify(t, points).failure == "");
            const auto change = [&](const std::string& name, auto span) {
                CAPTURE(name);
                using T = std::remove_const_t<typename decltype(span)::element_type>;
                for (int k = 0; k < 4 && !span.empty(); ++k) {
                    const std::size_t i = random.below(span.size());
                    CAPTURE(i);
                    T& value = const_cast<T&>(span[i]);
                    const T old = value;
                    if constexpr (std::is_same_v<T, votess::CellStatus>)
                        value =
                            old == T::certified ? std::array{T::empty, T::needs_exact}[random.below(2)] : T::certified;
                    else if constexpr (std::is_floating_point_v<T>)
                        value =
                            std::isfinite(old) ? (random.chance(0.3) ? static_cast<T>(NAN) : old * 1.001 + 1.1e-3) : 1;
                    else
                        value = static_cast<T>(old + (random.chance(0.5) ? 1 : -1));
                    CHECK_FALSE(votess::verify(t, points).passed);
                    value = old;
                    ++tried;
                }
            };
            votess::for_all_arrays([&](const auto& array) {
                if (array.name != "weights" && array.name != "ids") change(std::string(array.name), array.of(t));
            });
            CHECK(votess::verify(t, points).failure == "");
        }
        CHECK(tried > test::by_size(500, 200));
    }

    TEST_CASE("verify proves hulls, whose corners are seeds with many walls") {
        for (const bool ball : {true, false}) {
            test::Coordinates points;
            test::Random random(112);
            for (std::size_t i = 0; i < 120; ++i) {
                const std::array x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
                const double r = std::hypot(x[0], x[1], x[2]) / (ball ? std::cbrt(random.uniform()) : 1);
                for (const double c : x) points.push_back(c / r);
            }
            votess::Options options;
            options.walls = votess::hull_walls(points);
            const auto t = votess::tessellate(std::span<const double>(points), options);
            CHECK(votess::verify(t, points).proven);
        }
    }

    TEST_CASE("verify proves a hull with a corner of many faces") {
        test::Coordinates points{0, 0, 1, 0.1, 0.2, 0.3, -0.2, 0.1, 0.2};
        for (int k = 0; k < 120; ++k)
            points.insert(points.end(), {std::cos(0.05 * k + 1e-3 * (k % 7)), std::sin(0.05 * k + 1e-3 * (k % 7)), 0});
        votess::Options options = rows_only();
        options.walls = votess::hull_walls(points);
        const auto t = votess::tessellate(std::span<const double>(points), options);
        CHECK(votess::verify(t, points).proven);
        test::Coordinates moved = points;
        std::swap_ranges(moved.begin() + 3, moved.begin() + 6, moved.begin() + 6);
        CHECK_FALSE(votess::verify(t, moved).passed);
    }

    // Sums of volumes have no digits there: places far away are rounded by more than the whole box is wide.
    TEST_CASE("verify proves cells of domains that end on some sides") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        const test::PointSet set = test::uniform(40, 115);
        test::Random random(116);
        for (const bool planar : {false, true})
            for (int endless = 1; endless < 8; ++endless)
                for (const bool weighted : {false, true}) {
                    CAPTURE(planar);
                    CAPTURE(endless);
                    CAPTURE(weighted);
                    test::Coordinates points;
                    for (std::size_t i = 0; i < set.points.size(); ++i)
                        if (!planar || i % 3 < 2) points.push_back(set.points[i]);
                    votess::Options options = rows_only();
                    options.planar = planar;
                    options.box = votess::Box{{0, 0, 0}, {1, 1, planar ? 0.0 : 1.0}};
                    for (std::size_t k = 0; k < (planar ? 2 : 3); ++k) {
                        if ((endless >> k & 1) == 0) continue;
                        options.box->upper[k] = inf;
                        if (random.chance(0.5)) options.box->lower[k] = -inf;
                    }
                    std::vector<double> weights;
                    for (std::size_t i = 0; weighted && i < set.size(); ++i) weights.push_back(random.uniform(0, 0.02));
                    options.weights = weights;
                    const auto t = votess::tessellate(std::span<const double>(points), options);
                    const votess::VerifyReport report = votess::verify(t, points);
                    CHECK(report.failure == "");
                    CHECK(report.unproven == "");
                }
    }

    // The box in which they are verified is long: rounded numbers do not settle which seeds exclude a hidden one.
    TEST_CASE("verify proves a sheet of weighted seeds in a domain without end") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        test::PointSet set = test::uniform(40, 117);
        test::Random random(118);
        std::vector<double> weights;
        for (std::size_t i = 0; i < set.size(); ++i) {
            set.points[3 * i + 2] = 0.5;
            weights.push_back(random.uniform(0, 0.1));
        }
        for (const bool endless : {false, true}) {
            votess::Options options = rows_only();
            options.weights = weights;
            options.box = votess::Box{{0, 0, -inf}, {1, 1, inf}};
            if (endless) options.box = test::cube(-inf, inf);
            const auto t = votess::tessellate(std::span<const double>(set.points), options);
            CHECK(std::ranges::count(t.status(), votess::CellStatus::empty) > 0);
            const votess::VerifyReport report = votess::verify(t, set.points);
            CHECK(report.failure == "");
            CHECK(report.proven);
        }
    }

    // Volumes of a box that ends far away underflow, or all digits are those of the cells at its ends.
    TEST_CASE("verify compares numbers of domains without end cell by cell") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        for (const double scale : {5e-16, 1.0, 1e60})
            for (int kind = 0; kind < 4; ++kind) {
                CAPTURE(scale);
                CAPTURE(kind);
                test::Coordinates points = test::uniform(30, 118).points;
                for (double& x : points) x *= scale;
                votess::Options options;
                options.device = "cpu";
                options.threads = 1;
                options.list_walls = kind % 2 == 0;
                options.want = {.neighbors = true, .volumes = true, .centroids = true, .areas = true};
                options.box = test::cube(-inf, inf);
                if (kind == 1) options.box->lower[0] = 0;
                if (kind >= 2) options.box->lower[0] = 0, options.box->upper[0] = scale, options.periodic[0] = true;
                if (kind == 3) options.box->lower[1] = 0, options.box->upper[1] = scale, options.periodic[1] = true;
                const auto t = votess::tessellate(std::span<const double>(points), options);
                const votess::VerifyReport report = votess::verify(t, points);
                CHECK(report.failure == "");
                CHECK(report.proven);
                const auto change = [&](std::span<const double> values, std::size_t i, double by) {
                    double& value = const_cast<double&>(values[i]);
                    const double old = value;
                    value += by;
                    CHECK_FALSE(votess::verify(t, points).passed);
                    value = old;
                };
                std::size_t closed = 0;
                for (std::size_t i = 0; i < t.size() && closed < 3; ++i) {
                    if (!std::isfinite(t.volumes()[i])) continue;
                    ++closed;
                    change(t.volumes(), i, 1e-6 * t.volumes()[i]);
                    change(t.centroids(), 3 * i + 1, 1e-6 * scale);
                    const auto entry = static_cast<std::size_t>(t.indptr()[i]);
                    change(t.face_areas(), entry, 1e-6 * scale * scale);
                }
                CHECK(closed > 0);
            }
    }

    // Rows of more than 512 faces are looked through in blocks.
    TEST_CASE("verify passes cells of the plane without end at any length") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        test::Random random(117);
        for (const int exponent : {-1000, -500, 0, 500, 1000})
            for (int set = 0; set < 4; ++set) {
                CAPTURE(exponent);
                CAPTURE(set);
                test::Coordinates points(10);
                for (double& x : points) x = std::ldexp(static_cast<double>(random.below(65)) / 64, exponent);
                votess::Options options;
                options.planar = true;
                options.box = votess::Box{{-inf, -inf, 0}, {inf, inf, 0}};
                options.want = {.neighbors = true, .volumes = true, .areas = true};
                CHECK(votess::verify(votess::tessellate(std::span<const double>(points), options), points).failure ==
                      "");
            }
    }

    TEST_CASE("verify passes cells of seeds nearer to each other than squares of distances reach") {
        test::Random random(121);
        for (const int exponent : {-290, -300, -310, -320, -330, -340, -350, -500, -512, -530, -560, -900, -1000}) {
            CAPTURE(exponent);
            test::Coordinates points(24);
            for (double& x : points) x = std::ldexp(random.uniform(), exponent);
            votess::Options options = test::all_options(test::unit_box());
            options.want.normals = options.want.areas = options.want.centroids = true;
            const auto t = votess::tessellate(std::span<const double>(points), options);
            CHECK(votess::verify(t, points).failure == "");
            // A face of the largest area, and its normal.
            const auto largest = std::ranges::max_element(t.face_areas()) - t.face_areas().begin();
            for (double* const value :
                 {const_cast<double*>(&t.face_areas()[static_cast<std::size_t>(largest)]),
                  const_cast<double*>(&t.face_normals()[static_cast<std::size_t>(3 * largest)])}) {
                const double right = *value;
                *value = right * 1.001 + 1e-5;
                CHECK_FALSE(votess::verify(t, points).passed);
                *value = right;
            }
        }
    }

    TEST_CASE("verify proves a cell of many faces, and finds what is wrong with it") {
        test::Coordinates points{0, 0, 0};
        test::Random random(117);
        for (std::size_t i = 0; i < 700; ++i) {
            std::array<double, 3> x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
            const double r = std::hypot(x[0], x[1], x[2]) * (i % 3 == 0 ? 1 : random.uniform(1, 1.0001));
            for (const double c : x) points.push_back(c / r);
        }
        votess::Options options = rows_only();
        options.box = test::cube(-2, 2);
        options.want.faces = options.want.vertices = true;
        const auto t = votess::tessellate(std::span<const double>(points), options);
        REQUIRE(t.neighbors(0).size() > 512);
        CHECK(votess::verify(t, points).proven);
        for (std::size_t tries = 0; tries < 4; ++tries) {
            test::Coordinates moved = points;
            const std::size_t i = tries % 2 == 0 ? 0 : static_cast<std::size_t>(t.neighbors(0)[31 * tries]);
            moved[3 * i + tries % 3] += tries % 2 == 0 ? 1e-3 : 0.01;
            CHECK_FALSE(votess::verify(t, moved).passed);
        }
    }

    TEST_CASE("verify says why cells are not proven") {
        constexpr double inf = std::numeric_limits<double>::infinity();
        const test::PointSet set = test::uniform(60, 113);
        const auto reason = [](const votess::Tessellation& t, std::span<const double> points,
                               const votess::VerifyOptions& how = {}) {
            const votess::VerifyReport report = votess::verify(t, points, how);
            CHECK(report.failure == "");
            CHECK(report.proven == report.unproven.empty());
            return report.unproven;
        };
        const auto plain = [&] {
            votess::Options options = rows_only();
            options.box = set.box;
            return options;
        };
        votess::Options options = plain();
        CHECK(reason(test::run(set, options), set.points) == "");
        CHECK(reason(test::run(set, options), set.points, {0, 1}) == "a number of cells was given, which are sampled");
        options.want = {false, true, false, false};
        CHECK(reason(test::run(set, options), set.points) == "");
        options = plain();
        options.min_area = 1e-3;
        CHECK(reason(test::run(set, options), set.points) == "");
        options.box = test::cube(-inf, inf);
        CHECK(reason(votess::tessellate(std::span<const double>(set.points), options), set.points) == "");
        CHECK(reason(votess::tessellate(std::span<const double>(set.points), options), set.points, {9, 1}) ==
              "a number of cells was given, which are sampled");
        options.planar = true;
        options.box = votess::Box{{0, 0, 0}, {1, 1, 0}};
        const auto flat = std::span<const double>(set.points).first(100);
        CHECK(reason(votess::tessellate(flat, options), flat) == "");
        options = plain();
        const std::vector<std::int64_t> ids{3, 7};
        options.only = ids;
        CHECK(reason(test::run(set, options), set.points) == "");
        CHECK(reason(test::run(set, options), set.points, {1, 1}) == "a number of cells was given, which are sampled");
        options = plain();
        const test::Coordinates vertices{-1, -1, -1, 4, -1, -1, -1, 4, -1, -1, -1, 4};
        const std::vector<std::int32_t> triangles{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
        options.box.reset();
        options.mesh = votess::TriangleMesh{vertices, triangles};
        const auto in_mesh = votess::tessellate(std::span<const double>(set.points), options);
        CHECK(reason(in_mesh, set.points) ==
              "the whole cells are proven, and their parts in the mesh equal those of a second run");
        CHECK(reason(in_mesh, set.points, {9, 1}) ==
              "a mesh cuts the cells, and a number of cells was given, which are sampled");
        CHECK(votess::verify(in_mesh, test::uniform(60, 114).points).unproven == "");  // it fails

        // The certificate gives up.
        test::Coordinates huge = set.points;
        for (double& x : huge) x *= 1e110;  // volumes overflow
        options = plain();
        options.box = test::cube(0, 1e110);
        const auto unbounded = votess::tessellate(std::span<const double>(huge), options);
        CHECK(reason(unbounded, huge) == "");  // by a place that one cell covers
        options.periodic = {true, true, true};
        CHECK(reason(votess::tessellate(std::span<const double>(huge), options), huge) ==
              "float64 cannot tell whether the cells fill the domain: they are too thin, too small or too large");
        test::Coordinates coplanar = set.points;
        for (std::size_t i = 0; i < coplanar.size(); i += 3) coplanar[i] = 0.5;
        options = plain();
        options.walls = {{{1, 0, 0}, 0.5}, {{-1, 0, 0}, -0.5}};  // they leave no volume
        CHECK(reason(votess::tessellate(std::span<const double>(coplanar), options), coplanar) ==
              "seed 0 has no cell, nor has any other");
        test::Coordinates twice = set.points;
        std::copy_n(twice.begin(), 3, twice.begin() + 3);
        const auto t = votess::tessellate(std::span<const double>(twice), plain());
        auto unnamed = result_with_parts(t, parts_of(t));
        unnamed->duplicate_of.resize_uninitialized(0);
        CHECK(reason(votess::Tessellation(std::move(unnamed)), twice) ==
              "seed 1 is a duplicate, and the result does not say of which one");
    }

    // These are faults as well, and verify() finds them by trying every seed.
    TEST_CASE("a certificate names the cell for which it finds neither a proof nor a fault") {
        ProofCase c;
        c.points = test::uniform(60, 119).points;
        c.weights.assign(60, 0);
        c.options = rows_only();
        c.options.box = test::unit_box();
        const votess::Tessellation right = c.run();
        CHECK(certificate_of(right, c).proven);
        // A seed that has a cell, and rows without it.
        c.weights[5] = -100;
        const Parts without = parts_of(c.run());
        c.weights[5] = 0;
        auto verdict = certificate_of(with_parts(right, without), c);
        CHECK_FALSE(verdict.proven);
        CHECK(verdict.fault.text == "");
        CHECK(verdict.unsettled.text == "seed 5 has no cell, and no few others were found that exclude it");
        CHECK_FALSE(votess::verify(with_parts(right, without), c.points).passed);
        // A row whose planes leave nothing: few, then too many to try all that may meet in a corner.
        for (const std::int32_t listed : {20, 50}) {
            CAPTURE(listed);
            ProofCase light = c;
            light.weights[5] = -100;
            Parts parts = parts_of(right);
            parts.rows[5].clear();
            for (std::int32_t id = 0; id <= listed; ++id)
                if (id != 5) add_face(parts, 5, {id, {}});
            const votess::Tessellation wrong = with_parts(right, parts);
            verdict = certificate_of(wrong, light);
            CHECK_FALSE(verdict.proven);
            CHECK(verdict.fault.text != "");
            CHECK(verdict.unsettled.text == (listed < 40 ? "" : "seed 5 has a cell whose corners were not all found"));
        }
    }

    TEST_CASE("verify names what it skips") {
        const test::PointSet set = test::uniform(300, 95);
        votess::Options options;
        options.threads = 1;
        options.want = {false, false, false, false};
        const auto nothing = votess::verify(test::run(set, options), set.points);
        CHECK(nothing.passed);
        CHECK(nothing.skipped == std::vector<std::string>{"volumes", "euler"});  // of a run of all cells, with rows
        CHECK(votess::verify(test::run(set, options), set.points, {9, 1}).skipped.size() == 4);
        options.want = {true, true, false, false};
        const auto usual = votess::verify(test::run(set, options), set.points);
        CHECK(usual.passed);
        CHECK(usual.skipped == std::vector<std::string>{"euler"});
    }
}
