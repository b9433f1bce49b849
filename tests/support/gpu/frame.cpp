#include "support/gpu/frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "input/settle.hpp"

namespace test::frame {

void run(Host& host, std::span<const Target* const> targets, const RecordOptions& options) {
    host.commands.begin();
    host.commands.barrier();
    for (const Target* target : targets) target->frame.record(host.commands.handle(), options);
    host.commands.barrier_to_host();
    host.commands.end();
    host.commands.submit();
    host.commands.wait();
    for (const Target* target : targets)
        for (const vk::Buffer* buffer :
             {&target->header, &target->cells, &target->indices, &target->geometry, &target->areas, &target->shifts})
            buffer->invalidate();
}

void run(Host& host, const Target& target, std::uint32_t count) {
    const Target* const one[] = {&target};
    run(host, one, {.count = count});
}

template <class Real>
Rows collect(const Plan& plan, const Target& target, std::size_t count, const std::optional<votess::Box>& box,
             const std::optional<votess::TriclinicBox>& cell) {
    Rows all;
    const std::uint32_t stride = plan.options().stride;
    const auto seeds = target.seeds.as<Real>();
    for (std::size_t i = 0; i < count; ++i) {
        const Cell& cell = target.cell(count)[i];
        const auto row = target.indices.as<std::int32_t>().subspan(cell.row_begin, cell.row_length);
        all.rows.emplace_back(row.begin(), row.end());
        all.shifts.emplace_back();
        for (std::uint32_t k = 0; k < cell.row_length && plan.sizes().shifts > 0; ++k) {
            const auto four = target.shifts.as<std::int8_t>().subspan(4 * (std::size_t{cell.row_begin} + k), 4);
            all.shifts[i].insert(all.shifts[i].end(), four.begin(), four.begin() + 3);
            CHECK(four[3] == 0);
        }
        all.areas.emplace_back();
        if (plan.sizes().areas > 0) {
            const auto areas = target.areas.as<float>().subspan(cell.row_begin, cell.row_length);
            all.areas[i].assign(areas.begin(), areas.end());
        }
        all.status.push_back(static_cast<CellStatus>(cell.status));
        if (plan.sizes().geometry == 0) continue;
        const auto g = target.geometry.as<float>().subspan(4 * i, 4);
        all.volumes.push_back(g[3]);
        for (std::size_t k = 0; k < 3; ++k) all.centroids.push_back(double{seeds[i * stride + k]} + double{g[k]});
    }
    const Resolved more = plan.resolve(std::span<const Real>(seeds), std::span<const Real>(target.weights.as<Real>()),
                                       target.cell(count), {.box = box, .cell = cell, .threads = 0});
    for (std::size_t r = 0; r < more.cells.size(); ++r) {
        const std::size_t i = more.cells[r];
        CHECK(all.rows[i].empty());
        all.rows[i].assign(more.indices.begin() + more.indptr[r], more.indices.begin() + more.indptr[r + 1]);
        if (plan.sizes().shifts > 0)
            all.shifts[i].assign(more.shifts.begin() + 3 * more.indptr[r],
                                 more.shifts.begin() + 3 * more.indptr[r + 1]);
        if (plan.sizes().areas > 0)
            all.areas[i].assign(more.areas.begin() + more.indptr[r], more.areas.begin() + more.indptr[r + 1]);
        all.status[i] = more.status[r];
        if (plan.sizes().geometry == 0) continue;
        all.volumes[i] = more.volumes[r];
        for (std::size_t k = 0; k < 3; ++k) all.centroids[3 * i + k] = more.centroids[3 * r + k];
    }
    return all;
}

template Rows collect<float>(const Plan&, const Target&, std::size_t, const std::optional<votess::Box>&,
                             const std::optional<votess::TriclinicBox>&);
template Rows collect<double>(const Plan&, const Target&, std::size_t, const std::optional<votess::Box>&,
                              const std::optional<votess::TriclinicBox>&);

void take_centroids(Rows& rows, const Target& target, const votess::Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i)
        if (target.cell(t.size())[i].status == 0)
            std::copy_n(t.centroids().begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                        rows.centroids.begin() + static_cast<std::ptrdiff_t>(3 * i));
}

std::string compare(const Rows& rows, const votess::Tessellation& t) {
    for (std::size_t i = 0; i < t.size(); ++i) {
        const std::string where = "cell " + std::to_string(i) + ": ";
        if (rows.status[i] != t.status()[i]) return where + "another status";
        if (!std::ranges::equal(rows.rows[i], t.neighbors(i))) return where + "another row";
        if (!t.shifts().empty() &&
            !std::ranges::equal(rows.shifts[i], t.shifts().subspan(3 * static_cast<std::size_t>(t.indptr()[i]),
                                                                   3 * t.neighbors(i).size())))
            return where + "another shift";
        const double volume = t.volumes()[i];
        if (t.status()[i] != CellStatus::certified) continue;
        // Frames hold float32.
        if (!(volume >= std::numeric_limits<float>::min() && volume <= std::numeric_limits<float>::max())) continue;
        if (!rows.areas[i].empty()) {
            const auto areas = t.face_areas().subspan(static_cast<std::size_t>(t.indptr()[i]), t.neighbors(i).size());
            // The row may lack faces of walls.
            const double surface =
                std::max(std::accumulate(areas.begin(), areas.end(), 0.0), std::pow(volume, 2.0 / 3));
            for (std::size_t e = 0; e < areas.size(); ++e)
                if (!(std::abs(rows.areas[i][e] - areas[e]) <= 1e-5 * surface)) return where + "another area";
        }
        if (rows.volumes.empty()) continue;
        if (!(std::abs(rows.volumes[i] - volume) <= 1e-5 * volume)) return where + "another volume";
        for (std::size_t k = 0; k < 3; ++k)
            if (!(std::abs(rows.centroids[3 * i + k] - t.centroids()[3 * i + k]) <= 1e-4 * std::cbrt(volume)))
                return where + "another centroid";
    }
    return "";
}

void check_header(const Header& h, std::span<const Cell> cells) {
    Header sums{};
    for (const Cell& cell : cells) {
        switch (static_cast<CellStatus>(cell.status)) {
            case CellStatus::certified:
                ++sums.certified;
                break;
            case CellStatus::duplicate:
                ++sums.duplicates;
                break;
            case CellStatus::empty:
                ++sums.empty;
                break;
            case CellStatus::outside:
                ++sums.outside;
                break;
            default:
                ++sums.unresolved;
        }
        sums.faces += cell.faces;
        sums.entries += cell.row_length;
    }
    CHECK(h.seeds == cells.size());
    CHECK(h.certified == sums.certified);
    CHECK(h.unresolved == sums.unresolved);
    CHECK(h.duplicates == sums.duplicates);
    CHECK(h.empty == sums.empty);
    CHECK(h.outside == sums.outside);
    CHECK(h.faces == sums.faces);
    CHECK(h.entries == sums.entries);
}

PlanOptions options_for(const PointSet& set) {
    PlanOptions options;
    options.max_seeds = static_cast<std::uint32_t>(set.size());
    options.format = SeedFormat::float64;
    options.max_entries = 64 * options.max_seeds;
    options.areas = true;  // most tests share the pipelines that measure them
    votess::Options whole;
    whole.box = set.box;
    options.box = votess::make_job(votess::settle({set.points, {}}, whole)).box;
    return options;
}

votess::Tessellation on_cpu(const PointSet& set, const PlanOptions& plan, std::span<const double> weights) {
    votess::Options options = test::all_options(plan.box);
    if (plan.cell) options.box.reset();
    options.cell = plan.cell;
    options.list_walls = plan.list_walls;
    options.periodic = plan.periodic;
    options.weights = weights;
    options.walls = plan.walls;
    if (!plan.walls.empty()) options.outside = votess::Outside::drop;
    options.device = "cpu";
    return votess::tessellate(std::span<const double>(set.points), options);
}

std::string check(Host& host, const PointSet& set, PlanOptions options) {
    const OneFrame frame(host, options, set.points);
    check_header(frame.head(), frame.cells());
    return compare(frame.rows(), on_cpu(set, options));
}

std::string check(Host& host, std::span<const PointSet> sets, PlanOptions options) {
    for (const PointSet& set : sets)
        options.max_seeds = std::max(options.max_seeds, static_cast<std::uint32_t>(set.size()));
    options.max_entries = 64 * options.max_seeds;
    options.format = SeedFormat::float64;
    options.areas = true;
    options.box = options_for(sets.front()).box;
    const Plan plan = host.plan(options);
    const Target target(host, plan);
    const Target* const one[] = {&target};
    for (const PointSet& set : sets) {
        options.box = options_for(set).box;
        target.write<double>(set.points, options.stride);
        run(host, one, {.count = static_cast<std::uint32_t>(set.size()), .box = options.box});
        check_header(target.head(), target.cell(set.size()));
        const std::string found = compare(collect<double>(plan, target, set.size(), options.box), on_cpu(set, options));
        if (!found.empty()) return set.name + ": " + found;
    }
    return "";
}

}  // namespace test::frame
