// ExactClipper: cells clipped in parts, in any order, equal those of a full run.
#include "output/exact_clipper.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <thread>

#include "cpu/cpu_clipper.hpp"
#include "fuzz/kinds/kinds.hpp"
#include "input/settle.hpp"
#include "support/check.hpp"
#include "support/generators.hpp"
#include "support/random.hpp"

using votess::CellStatus;
using votess::ExactClipper;
using votess::ResultBuilder;
using votess::Tessellation;
using Cells = std::vector<std::int32_t>;

namespace {

constexpr votess::Share whole{0, 1};

// Random disjoint parts that together hold every cell; the last may be empty.
std::vector<Cells> random_parts(std::size_t count, std::size_t parts, std::uint64_t seed) {
    test::Random random(seed);
    std::vector<Cells> all(parts);
    for (const std::size_t i : test::permutation(count, random))
        all[random.below(std::max<std::size_t>(parts - 1, 1))].push_back(static_cast<std::int32_t>(i));
    return all;
}

// Clips part after part, as another engine does that could certify no cell.
Tessellation clip_parts(ExactClipper& clipper, const votess::Points& points, const votess::Options& options,
                        const std::vector<Cells>& parts) {
    const votess::Job job = votess::make_job(votess::settle(points, options));
    ResultBuilder builder;
    clipper.begin(job);
    builder.begin(job, clipper.pool());
    std::ranges::fill(builder.arrays().status, CellStatus::needs_exact);
    for (const Cells& part : parts) clipper.clip(part, builder, whole);
    const auto duplicate_of = clipper.duplicate_of();
    builder.set_duplicates(duplicate_of, clipper.pool());
    auto result = std::make_shared<votess::detail::Result>();
    builder.finish(*result, clipper.pool());
    clipper.end();
    return Tessellation(std::move(result));
}

Tessellation clip_parts(ExactClipper& clipper, const test::PointSet& set, votess::Options options,
                        const std::vector<Cells>& parts) {
    options.box = set.box;
    return clip_parts(clipper, {set.points, {}}, options, parts);
}

std::string compare(const Tessellation& full, const Tessellation& parts) {
    const auto &a = full.stats(), &b = parts.stats();
    if (a.faces != b.faces || a.duplicates != b.duplicates || a.empty_cells != b.empty_cells ||
        a.mean_faces != b.mean_faces || std::abs(a.volume_sum - b.volume_sum) > 1e-9 * a.volume_sum ||
        a.box_volume != b.box_volume || a.points != b.points || a.threads != b.threads)
        return "stats differ";
    if (b.fallback_cells != b.points - b.duplicates) return "fallback_cells is wrong";
    return test::check_same_cells(full, parts);
}

// Clips all cells from the lists of a full run, so that none of them is walked.
Tessellation clip_lists(const votess::Points& points, const votess::Options& options, const Tessellation& full) {
    const votess::Job job = votess::make_job(votess::settle(points, options));
    votess::cpu::CpuClipper clipper;
    ResultBuilder builder;
    clipper.begin(job);
    builder.begin(job, clipper.pool());
    Cells cells;
    std::vector<std::uint32_t> lengths;
    for (std::size_t i = 0; i < full.size(); ++i) {
        if (full.status()[i] != CellStatus::certified) {
            builder.set_empty(i, full.status()[i]);
            continue;
        }
        cells.push_back(static_cast<std::int32_t>(i));
        lengths.push_back(static_cast<std::uint32_t>(full.neighbors(i).size()));
    }
    std::vector<std::array<std::int8_t, 3>> shifts(full.shifts().size() / 3);
    for (std::size_t e = 0; e < shifts.size(); ++e) std::copy_n(&full.shifts()[3 * e], 3, shifts[e].begin());
    clipper.clip_listed({cells, lengths, full.indices(), shifts}, builder, whole);
    builder.set_duplicates(clipper.duplicate_of(), clipper.pool());
    auto result = std::make_shared<votess::detail::Result>();
    builder.finish(*result, clipper.pool());
    clipper.end();
    return Tessellation(std::move(result));
}

std::vector<test::PointSet> some_families(std::size_t n) {
    return {test::uniform(n, 1),
            test::clustered(n, 2),
            test::nested_clusters(n, 3),
            test::near_duplicates(n, 4),
            test::on_walls(n, 5),
            test::with_duplicates(n, n / 5, 6),
            test::cubic(8),
            test::on_sphere(std::min<std::size_t>(n, 300), 7),
            test::on_oblique_line(50, 8)};
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("exact clipper: random parts give the arrays of a full run, with 1, 2 and 5 threads") {
        for (const test::PointSet& set : some_families(test::by_size(1500, 150))) {
            CAPTURE(set.name);
            for (const unsigned threads : {1u, 2u, 5u}) {
                auto options = test::all_options();
                options.threads = threads;
                const auto full = test::run(set, options);
                votess::cpu::CpuClipper clipper;
                for (const std::size_t parts : {1, 2, 5})
                    CHECK(compare(full, clip_parts(clipper, set, options, random_parts(set.size(), parts, parts))) ==
                          "");
            }
        }
    }

    TEST_CASE("exact clipper: cells that are clipped from lists have the digits of those that are walked") {
        std::uint64_t sets = 0;
        for (const test::fuzz::Kind& kind : test::fuzz::all_kinds()) {
            const std::uint64_t usual = kind.name == "many" ? 1 : 10;
            const std::uint64_t count = test::by_size(usual, usual / 10 + 1);
            for (std::uint64_t number = 1; number <= count; ++number) {
                CAPTURE(kind.name);
                CAPTURE(number);
                for (const test::fuzz::Job& given : test::fuzz::make_case(kind, number).jobs) {
                    votess::Options options = given.options("cpu");
                    options.want = {.neighbors = true, .volumes = true, .centroids = true, .counts = true};
                    options.want.areas = options.want.normals = options.want.surfaces = options.want.radii = true;
                    options.list_walls = true;
                    try {
                        const auto full = votess::tessellate(given.points, options);
                        CHECK(test::check_identical(full, clip_lists({given.points, {}}, options, full)) == "");
                        ++sets;
                    } catch (const votess::Error& error) {
                        CHECK(error.code() != votess::ErrorCode::internal);  // some are there to be refused
                    }
                }
            }
        }
        CHECK(sets > 10);
    }

    TEST_CASE("exact clipper: every choice of arrays") {
        const auto set = test::with_duplicates(test::by_size(800, 200), 50, 11);
        votess::cpu::CpuClipper clipper;
        for (unsigned bits = 0; bits < 64; ++bits) {
            CAPTURE(bits);
            auto options = test::all_options();
            options.want = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, (bits & 32) != 0};
            options.list_walls = (bits & 16) != 0;
            CHECK(compare(test::run(set, options),
                          clip_parts(clipper, set, options, random_parts(set.size(), 3, bits))) == "");
        }
    }

    TEST_CASE("exact clipper: no cells need no preparation; duplicates are found all the same") {
        const auto set = test::with_duplicates(300, 20, 14);
        auto options = test::all_options(set.box);
        const votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
        votess::cpu::CpuClipper clipper;
        ResultBuilder builder;
        clipper.begin(job);
        builder.begin(job, clipper.pool());
        clipper.clip({}, builder, whole);
        const auto full = test::run(set);
        CHECK(std::ranges::equal(clipper.duplicate_of(), full.duplicate_of()));
        clipper.prepare();
        clipper.prepare();
        CHECK(std::ranges::equal(clipper.duplicate_of(), full.duplicate_of()));

        options.duplicates = votess::Duplicates::error;
        clipper.begin(votess::make_job(votess::settle({set.points, {}}, options)));
        CHECK_THROWS_AS(clipper.prepare(), votess::Error);
        CHECK_THROWS_AS((void)clipper.duplicate_of(), votess::Error);
    }

    TEST_CASE("exact clipper: cancelling from the calling thread, then another job") {
        const auto set = test::uniform(test::by_size(30000, 8000), 15);
        auto options = test::all_options(set.box);
        options.threads = 3;
        const auto caller = std::this_thread::get_id();
        bool elsewhere = false;
        double least = 1, most = 0;
        options.progress = [&](double fraction) {
            elsewhere = elsewhere || std::this_thread::get_id() != caller;
            least = std::min(least, fraction), most = std::max(most, fraction);
            return false;
        };
        const votess::Job job = votess::make_job(votess::settle({set.points, {}}, options));
        votess::cpu::CpuClipper clipper;
        ResultBuilder builder;
        clipper.begin(job);
        builder.begin(job, clipper.pool());
        Cells all(set.size());
        std::iota(all.begin(), all.end(), 0);
        CHECK_THROWS_AS(clipper.clip(all, builder, {0.5, 0.75}), votess::Error);
        CHECK_FALSE(elsewhere);
        CHECK(least >= 0.5);
        CHECK(most <= 0.75);
        const auto small = test::uniform(200, 16);
        CHECK(compare(test::run(small), clip_parts(clipper, small, test::all_options(), random_parts(200, 3, 17))) ==
              "");
    }

    TEST_CASE("result builder: rows of two engines, copied and handed over, unresolved cells in between") {
        const auto set = test::clustered(test::by_size(10000, 1000), 18);
        const auto full = test::run(set);
        const votess::Job job = votess::make_job(votess::settle({set.points, {}}, test::all_options(set.box)));
        votess::cpu::CpuClipper clipper;
        ResultBuilder builder;
        for (const bool copied : {false, true}) {
            clipper.begin(job);
            builder.begin(job, clipper.pool());
            // The other engine knows the rows of all cells but every seventh; two chunks of unequal size.
            test::Random random(19);
            Cells order, unresolved;
            for (const std::size_t i : test::permutation(set.size(), random))
                order.push_back(static_cast<std::int32_t>(i));
            std::span<const std::int32_t> cells = order;
            if (!copied) {
                const auto kept = builder.allocate_cells(order.size());
                std::ranges::copy(order, kept.begin());
                cells = kept;
            }
            std::uint64_t faces = 0;
            for (std::size_t begin = 0, size = set.size() / 5; begin < set.size(); begin += size, size *= 8) {
                const auto chunk = cells.subspan(begin, std::min(size, set.size() - begin));
                std::vector<std::uint32_t> lengths;
                Cells ids;
                std::vector<double> areas;
                for (const std::int32_t cell : chunk) {
                    const auto i = static_cast<std::size_t>(cell);
                    const auto row = full.neighbors(i);
                    if (cell % 7 == 0) {
                        builder.arrays().status[i] = CellStatus::vertex_overflow;
                        unresolved.push_back(cell);
                        lengths.push_back(0);
                        continue;
                    }
                    lengths.push_back(static_cast<std::uint32_t>(row.size()));
                    ids.insert(ids.end(), row.begin(), row.end());
                    const auto row_areas =
                        full.face_areas().subspan(static_cast<std::size_t>(full.indptr()[i]), row.size());
                    areas.insert(areas.end(), row_areas.begin(), row_areas.end());
                    faces += row.size();
                    builder.arrays().volumes[i] = full.volumes()[i];
                    std::copy_n(full.centroids().data() + 3 * i, 3, builder.arrays().centroids.data() + 3 * i);
                    builder.arrays().face_counts[i] = full.face_counts()[i];
                    builder.arrays().edge_counts[i] = full.edge_counts()[i];
                    builder.arrays().vertex_counts[i] = full.vertex_counts()[i];
                }
                if (copied)
                    builder.copy_rows(chunk, lengths, ids, {areas, {}, {}});
                else
                    builder.add_rows(chunk, lengths, ids, {areas, {}, {}});
            }
            builder.count({.faces = faces});
            order.assign(order.size(), -1);
            clipper.clip(unresolved, builder, whole);
            votess::detail::Result result;
            result.stats.device = "both";
            builder.finish(result, clipper.pool());
            clipper.end();
            CHECK(result.stats.device == "both");
            CHECK(result.stats.fallback_cells == unresolved.size());
            CHECK(result.stats.faces == full.stats().faces);
            const Tessellation both(std::make_shared<const votess::detail::Result>(std::move(result)));
            CHECK(test::check_same_cells(full, both) == "");
        }
    }

    TEST_CASE("result builder: an engine's bug is an error") {
        const auto set = test::uniform(10, 20);
        votess::Job job = votess::make_job(votess::settle({set.points, {}}, test::all_options(set.box)));
        const std::vector<double> two_areas{1, 2}, three_areas{1, 2, 3};
        votess::ThreadPool pool(1);
        ResultBuilder measuring;
        measuring.begin(job, pool);
        CHECK_THROWS_AS(
            measuring.add_rows(Cells{3, 4}, std::vector<std::uint32_t>{1, 2}, Cells{1, 2, 3}, {two_areas, {}, {}}),
            votess::Error);
        measuring.begin(job, pool);
        CHECK_THROWS_AS(measuring.copy_rows(Cells{3, 4}, std::vector<std::uint32_t>{1, 2}, Cells{1, 2, 3}),
                        votess::Error);
        measuring.begin(job, pool);
        measuring.copy_rows(Cells{3, 4}, std::vector<std::uint32_t>{1, 2}, Cells{1, 2, 3}, {three_areas, {}, {}});
        job.want.areas = false;
        const Cells cells{3, 4}, beyond{3, 10}, negative{-1, 4};
        const std::vector<std::uint32_t> lengths{1, 2};
        ResultBuilder builder;
        builder.begin(job, pool);
        CHECK_THROWS_AS(builder.add_rows(cells, lengths, Cells{1, 2}), votess::Error);
        builder.begin(job, pool);
        CHECK_THROWS_AS(builder.copy_rows(cells, lengths, Cells{1, 2, 3, 4}), votess::Error);
        CHECK_THROWS_AS(builder.add_rows(beyond, lengths, Cells{1, 2, 3}), votess::Error);
        builder.begin(job, pool);
        CHECK_THROWS_AS(builder.add_rows(negative, lengths, Cells{1, 2, 3}), votess::Error);
        builder.begin(job, pool);
        builder.add_rows(cells, lengths, Cells{1, 2, 3});
        CHECK_THROWS_AS(builder.add_rows(cells, lengths, Cells{1, 2, 3}), votess::Error);
        builder.begin(job, pool);
        builder.arrays().status[7] = CellStatus::candidates_exhausted;
        votess::detail::Result result;
        CHECK_THROWS_AS(builder.finish(result, pool), votess::Error);
        votess::cpu::CpuClipper clipper;
        clipper.begin(job);
        CHECK_THROWS_AS(clipper.clip(beyond, builder, whole), votess::Error);
    }
}
