#include "distributed/blocks/local_block.hpp"

#include <algorithm>
#include <cmath>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/huge_pages.hpp"
#include "core/progress.hpp"
#include "distributed/blocks/far_cells.hpp"
#include "input/settle.hpp"
#include "query/locator.hpp"
#include "result/arrays.hpp"
#include "walk/star_bounds.hpp"

namespace votess::blocks {
namespace {

Settled part_of(const Settled& whole, const Seeds& seeds) {
    Settled part = whole;
    part.points = {seeds.points, {}};
    part.weights = {seeds.weights};
    // Measures include the radius. Without it Run::reach_of() needs rows.
    part.want.radii |= part.want.volumes || part.want.centroids || part.want.areas || part.want.surfaces;
    part.want.neighbors |= !part.want.radii;
    return part;
}

constexpr std::size_t task_seeds = 4096;

// Returns the rank of each id. The ids ascend up to `middle`, and again from there.
std::vector<std::int32_t> places_by_id(std::span<const std::int64_t> ids, std::size_t middle) {
    std::vector<std::int32_t> places;
    resize_in_huge_pages(places, ids.size());
    for (std::size_t k = 0, first = 0, second = middle; k < ids.size(); ++k) {
        const bool is_first = first < middle && (second == ids.size() || ids[first] <= ids[second]);
        places[is_first ? first++ : second++] = static_cast<std::int32_t>(k);
    }
    return places;
}

// Appends cells to the arrays of the block.
class Merger {
public:
    Merger(BlockCells& out, std::size_t cells, std::size_t entries) : out_(out), cells_(cells), entries_(entries) {
        out_.indptr.reserve(cells + 1);
        out_.indptr.push_back(0);
    }

    // from: the result of a run with these seeds.
    void add(const detail::Result& from, std::size_t i, const Seeds& seeds) {
        const auto begin = static_cast<std::size_t>(from.indptr[i]), end = static_cast<std::size_t>(from.indptr[i + 1]);
        for (std::size_t e = begin; e < end; ++e) {
            const std::int32_t index = from.indices[e];
            const auto seed = static_cast<std::size_t>(index);
            out_.indices.push_back(index < 0 ? index : seeds.ids[seed]);
            out_.owners.push_back(index < 0 ? -1 : seeds.tags[seed]);
        }
        for_row_arrays([&](const auto& array, std::size_t number) {
            if (number == ids || number == duplicates) return;
            const bool of_cell = array.per == Per::cell;
            const std::size_t each = components_of(array, from.planar);
            append(array.of(out_), array.of(from), each * (of_cell ? i : begin), each * (of_cell ? i + 1 : end),
                   each * (of_cell ? cells_ : entries_));
        });
        out_.indptr.push_back(static_cast<std::int64_t>(out_.indices.size()));
    }

private:
    // Ids of the seeds of the run: indices and duplicate_of name places among them.
    static constexpr std::size_t ids = detail::number_of("indices"), duplicates = detail::number_of("duplicate_of");

    template <class T, class U>
    static void append(std::vector<T>& to, const Buffer<U>& from, std::size_t begin, std::size_t end,
                       std::size_t room) {
        if (from.size() == 0) return;
        if (to.empty()) to.reserve(room);
        to.insert(to.end(), from.data() + begin, from.data() + end);
    }

    BlockCells& out_;
    std::size_t cells_, entries_;
};

}  // namespace

void Run::clip(const Settled& whole, std::size_t first) {
    row_order = places_by_id(seeds.ids, first);
    job = make_job(part_of(whole, seeds));
    job.row_order = row_order;
    clipper.begin(job);
    Progress progress(whole.progress);
    const bool lists = job.want.neighbors;
    {
        const Stoppable stoppable(progress);
        if (lists) clipper.sort();  // without it prepare() would release memory that the rows borrow
        clipper.prepare();
    }
    Job of_first = job;
    of_first.points.f64 = of_first.points.f64.first(3 * first);
    of_first.reports_weights = false;
    ResultBuilder builder;
    ThreadPool& pool = clipper.pool();
    builder.begin(of_first, pool);
    if (lists) clipper.lend_scratch(builder);
    if (!job.want.radii) powers.assign(first, cpu::Star::min_power);
    clipper.clip_first(first, powers, builder, clipping);
    Progress::require(progress.going_on(clipping.end));
    const Stoppable stoppable(progress);
    clipper.set_empty(builder);
    const auto duplicate_of = clipper.duplicate_of();
    builder.set_duplicates(duplicate_of.first(std::min(first, duplicate_of.size())), pool);
    builder.finish(result, pool);
}

void Run::clip_rows(std::vector<std::int32_t> cells) {
    rows_of = std::make_shared<Subset>(std::move(cells));
    Job lists = job;
    lists.want = {};
    lists.want.volumes = false;
    lists.only = rows_of;
    lists.reports_weights = false;
    ResultBuilder builder;
    builder.begin(lists, clipper.pool());
    clipper.clip_more(lists, builder, {clipping.end, clipping.end});
    builder.finish(rows, clipper.pool());
}

Seeds with_others(Seeds cells, const Seeds& others) {
    const std::size_t count = cells.size();
    const Seeds sorted = others.sorted();
    for (std::size_t i = 0; i < sorted.size(); ++i)
        if (!std::ranges::binary_search(cells.ids.begin(), cells.ids.begin() + static_cast<std::ptrdiff_t>(count),
                                        sorted.ids[i]))
            cells.add(sorted, i);
    return cells;
}

// All vertices count. Those that the cell did not find itself, a neighbor among the first seeds found.
double Run::reach_of(std::size_t cell, double heaviest) const {
    const double weight = job.domain->weights.empty() ? 0 : job.domain->weights[cell];
    if (!result.security_radii.empty()) {
        const double radius = 0.5 * result.security_radii[cell] * job.scale;
        return reach_within(radius * radius, heaviest - weight);
    }
    double power = powers[cell];
    for (const std::int32_t neighbor : neighbors(cell))
        if (neighbor >= 0 && static_cast<std::size_t>(neighbor) < powers.size())
            power = std::max(power, powers[static_cast<std::size_t>(neighbor)]);
    const double square = cpu::bounds::back(power, weight);
    return reach_within(square, heaviest - weight);
}

Run::Row Run::row_of(std::size_t cell) const {
    const detail::Result& of = has_rows() ? result : rows;
    const auto row = has_rows() ? cell : static_cast<std::size_t>(rows_of->row_of(static_cast<std::int32_t>(cell)));
    const auto begin = static_cast<std::size_t>(of.indptr[row]), end = static_cast<std::size_t>(of.indptr[row + 1]);
    return {&of, begin, end - begin};
}

LocalBlock::LocalBlock(const Settled& whole, Seeds own)
    : whole_(whole),
      count_(own.size()),
      job_(make_job(part_of(whole, own))),
      nearness_(*job_.domain),
      far_(std::make_unique<FarCells>()) {
    all_.seeds = std::move(own);
    job_.points = {};
    ThreadPool& pool = all_.clipper.pool_of(whole.threads);
    resize_in_huge_pages(places_, count_);
    pool.run(ceil_div(count_, task_seeds), [&](std::size_t task, unsigned) {
        for (std::size_t i = task * task_seeds; i < std::min(count_, (task + 1) * task_seeds); ++i) {
            const auto place = cpu::place_in(*job_.domain, point_of(all_.seeds.points, i, job_.scale));
            if (!place)
                refuse("seed " + std::to_string(all_.seeds.ids[i]) +
                       " lies more than 500 million periods away from the box");
            places_[i] = place->at;
        }
    });
    tiled_ = tile_seeds(places_, job_.domain->weights, pool);
}

LocalBlock::~LocalBlock() = default;

Seeds LocalBlock::halo_for(const Outline& other) const {
    Seeds halo;
    if (other.tiles.empty()) return halo;
    for (std::size_t t = 0; t < tiled_.outline.tiles.size(); ++t) {
        const Nearness::Halo of_tile = nearness_.halo_of(tiled_.outline.tiles[t], other.box);
        if (of_tile.by.empty()) continue;
        for (std::size_t k = tiled_.begin[t]; k < tiled_.begin[t + 1]; ++k)
            if (Nearness::holds(of_tile, places_[tiled_.order[k]])) halo.add(all_.seeds, tiled_.order[k]);
    }
    return halo;
}

void LocalBlock::clip(std::vector<Outline> outlines, std::size_t number, Seeds halo) {
    outlines_ = std::move(outlines);
    number_ = number;
    counts_.given += halo.size();
    all_.seeds.reserve(count_ + halo.size());
    all_.seeds.add(halo.sorted());
    halo = {};
    all_.clip(whole_, count_);
    reserve_in_huge_pages(positions_, all_.seeds.size());
    positions_.assign(all_.seeds.size(), -1);
    const auto& input = all_.clipper.seeds().input;
    for (std::size_t s = 0; s < input.size(); ++s)
        positions_[static_cast<std::size_t>(input[s])] = static_cast<std::int32_t>(s);
    make_requests();
}

double LocalBlock::weight_of(std::size_t cell) const {
    return job_.domain->weights.empty() ? 0 : job_.domain->weights[cell];
}

// Returns a bound on the reach of all cells, whatever their neighbors are.
double LocalBlock::longest_reach(double heaviest) const {
    const auto& radii = all_.result.security_radii;
    if (all_.powers.empty() && radii.empty()) return 0;
    const auto& weights = job_.domain->weights;
    const auto [lightest, own_heaviest] =
        weights.empty() ? std::pair(0.0, 0.0) : std::pair(std::ranges::min(weights), std::ranges::max(weights));
    if (radii.empty()) {
        const double square = cpu::bounds::back(std::ranges::max(all_.powers), own_heaviest);
        return reach_within(square, heaviest - lightest);
    }
    const double radius = 0.5 * std::ranges::max(radii) * job_.scale;
    return reach_within(radius * radius, heaviest - lightest);
}

bool LocalBlock::any_near(std::size_t tile, double reach) const {
    const Box& home = tiled_.outline.tiles[tile].box;
    bool any = false;
    for (std::size_t b = 0; b < outlines_.size() && !any; ++b)
        if (b != number_)
            outlines_[b].for_tiles([&](const Box& box) { return !any && nearness_.is_near(box, home, reach); },
                                   [&](std::size_t) { any = true; });
    return any;
}

std::vector<LocalBlock::Unknown> LocalBlock::unknown_near(std::size_t tile, double reach) const {
    std::vector<Unknown> unknown;
    const Box& home = tiled_.outline.tiles[tile].box;
    for (std::size_t b = 0; b < outlines_.size(); ++b) {
        const Outline& other = outlines_[b];
        if (b == number_) continue;
        other.for_tiles([&](const Box& box) { return nearness_.is_near(box, home, reach); },
                        [&](std::size_t t) {
                            const Tile& tile = other.tiles[t];
                            nearness_.for_unknown(tile, tiled_.outline.box, home, reach, [&](const Box& box) {
                                unknown.push_back({box, static_cast<std::uint32_t>(b), tile.largest_weight,
                                                   distance_squared(box, home)});
                            });
                        });
    }
    return unknown;
}

PendingCells LocalBlock::pending_cells() const {
    PendingCells pending;
    for (const std::uint32_t cell : pending_) pending.cells.add(all_.seeds, cell);
    for (const std::int32_t i : kept_neighbors_) pending.kept_neighbors.add(all_.seeds, static_cast<std::size_t>(i));
    pending.kept_neighbors = pending.kept_neighbors.sorted();
    pending.faces = pending_faces_;
    return pending;
}

// The neighbors of pending cells are among those that they had and those of the replies.
void finish_pending(const Settled& whole, const PendingCells& pending, const Seeds& replies, Run& run) {
    if (pending.cells.size() == 0) return;
    Seeds others = pending.kept_neighbors;
    others.add(replies);
    run.seeds = with_others(pending.cells, others);
    run.clip(whole, pending.cells.size());
}

void LocalBlock::complete(const Seeds& replies, const BlockDomain& domain) {
    counts_.given += replies.size();
    finish_pending(whole_, pending_cells(), replies, pending_run_);
    std::vector<std::uint32_t> rows = far_->take(domain, all_, count_, pending_);
    for (const std::uint32_t row : far_->take(domain, pending_run_, pending_.size(), {})) rows.push_back(pending_[row]);
    std::ranges::sort(rows);
    std::ranges::sort(far_->ids);  // as the own seeds
    far_row_.assign(count_, -1);
    for (std::size_t k = 0; k < rows.size(); ++k) far_row_[rows[k]] = static_cast<std::int32_t>(k);
}

const FarCells& LocalBlock::far() const {
    return *far_;
}

BlockCells LocalBlock::finish(const FarCells& all, const BlockDomain& domain) {
    Run far_run;
    find_far(domain, all, far_->ids, far_run);
    counts_.exact_cells = 0;
    for (Run* run : {&all_, &pending_run_, &far_run}) {
        counts_.exact_cells += run->result.stats.exact_cells;
        domain.complete(run->result);
    }

    BlockCells cells;
    const std::size_t entries =
        all_.result.indices.size() + pending_run_.result.indices.size() + far_run.result.indices.size();
    cells.indices.reserve(entries);
    cells.owners.reserve(entries);
    Merger merger(cells, count_, entries);
    const std::span own_ids = std::span(all_.seeds.ids).first(count_);
    std::vector<std::int64_t> foreign_neighbors;
    const auto add = [&](const Run& from, std::size_t i, std::size_t first_other) {
        merger.add(from.result, i, from.seeds);
        for (auto e = from.result.indptr[i]; e < from.result.indptr[i + 1]; ++e) {
            const std::int32_t index = from.result.indices[static_cast<std::size_t>(e)];
            if (index < 0 || static_cast<std::size_t>(index) < first_other) continue;
            const std::int64_t id = from.seeds.ids[static_cast<std::size_t>(index)];
            if (!std::ranges::binary_search(own_ids, id)) foreign_neighbors.push_back(id);
        }
    };
    for (std::size_t i = 0, pending = 0; i < count_; ++i) {
        const std::size_t row = pending;
        const bool is_pending = pending < pending_.size() && pending_[pending] == i;
        if (is_pending) ++pending;
        if (far_row_[i] >= 0)
            add(far_run, static_cast<std::size_t>(far_row_[i]), 0);
        else if (is_pending)
            add(pending_run_, row, pending_.size());
        else
            add(all_, i, count_);
    }
    if (!whole_.want.radii) cells.security_radii.clear();
    std::ranges::sort(foreign_neighbors);
    const auto [end, last] = std::ranges::unique(foreign_neighbors);
    counts_.needed = static_cast<std::uint64_t>(end - foreign_neighbors.begin());
    for (const std::int32_t of : all_.result.duplicate_of)
        cells.duplicate_of.push_back(of < 0 ? -1 : all_.seeds.ids[static_cast<std::size_t>(of)]);
    return cells;
}

}  // namespace votess::blocks
