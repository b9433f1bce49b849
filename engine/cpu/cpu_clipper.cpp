#include "cpu/cpu_clipper.hpp"

#include <algorithm>
#include <functional>
#include <iterator>

#include "core/arithmetic.hpp"
#include "core/text.hpp"
#include "index/buried_seeds.hpp"
#include "input/settle.hpp"
#include "input/settled.hpp"
#include "walk/star_bounds.hpp"

namespace votess::cpu {
namespace {

// Blocks are tasks and stretches: neighbors in space, which share their vertices. Longer blocks compute fewer vertices
// twice; later ones are shorter, so that threads end together. Lists and measures do not depend on blocks. The last
// bits of vertices do, so blocks of a mesh depend on the number of seeds alone, unless there are many threads. They
// also store positions of vertices, for which longer blocks gain nothing.
constexpr std::size_t longest_block = 65536, longest_placed = 16384, shortest_block = 2048, fewest_placed = 4;
constexpr std::size_t many_threads = 32, parts_per_thread = 2;
constexpr std::size_t sparse_stretch = 16384;                  // seeds, when few of them have cells
constexpr std::size_t min_block_seeds = 16;                    // of few cells, so that all threads get some
constexpr std::size_t blocks_per_thread = 8, few_placed = 64;  // of few cells
constexpr std::size_t listed_block = 512;                      // cells of clip_listed() in a task
constexpr std::size_t index_task = 65536;                      // entries of the inverse order in a task
// Cells of a window lie where one slope of the weights puts them, unless the weights follow a steeper paraboloid.
constexpr double max_walked_curvature = 0.2;
constexpr std::size_t cells_per_check = 64;  // between calls of check_stop()
constexpr std::size_t hidden_in_a_row = 2;   // then the next seed probably is, too

}  // namespace

void CpuClipper::begin(const Job& job) {
    end();
    job_ = job;
    progress_ = Progress(job.progress);
    pool_of(job.threads);
    const Kernels* kernels = find_kernels(job.instructions);
    if (kernels == nullptr) throw Error(ErrorCode::internal, "the options have not been checked");
    if (kernels != kernels_) workers_.clear();
    kernels_ = kernels;
}

ThreadPool& CpuClipper::pool_of(unsigned threads) {
    if (!pool_ || pool_->requested() != threads || !pool_->has_threads()) pool_.emplace(threads);
    return *pool_;
}

void CpuClipper::end() {
    positions_known_ = false;
    kept_ = nullptr;
    delaunay_.reset();
    unwrapped_.reset();
    sorted_ = searchable_ = false;
    buried_.clear();
    progress_ = {};
    job_ = {};
}

void CpuClipper::lend_seeds(ResultBuilder& out) {
    sorted_ = searchable_ = false;
    for (auto* axis : {&seeds_.x, &seeds_.y, &seeds_.z}) out.lend(axis->memory());
    hierarchy_.for_memory([&](std::span<std::byte> memory) { out.lend(memory); });
}

void CpuClipper::sort(std::span<const std::int32_t> order, Keep keep) {
    seeds_.images = nullptr;
    seeds_.weights.clear();
    buried_.clear();
    searchable_ = positions_known_ = false;
    delaunay_.reset();
    unwrapped_.reset();
    const auto bury = [&] {
        bury_lighter();
        if (keep != Keep::all && job_.domain->has_weights() && job_.beyond.empty())
            drop_buried(*job_.domain, *pool_, keep == Keep::all_unless_most, seeds_, buried_);
    };
    if (job_.domain->is_periodic())
        images_.sort(job_, order, sorter_, *pool_, seeds_, bury);
    else if (!order.empty())
        put_in_order(job_.points, job_.scale, order, *pool_, seeds_);
    else
        sort_inside(job_.points, job_.scale, job_.grid_resolution, job_.outside, sorter_, *pool_, seeds_);
    lacks_images_ = job_.domain->is_periodic() && !order.empty();
    if (!job_.domain->is_periodic()) bury();
    weigh_places();
    gather_beyond();
    row_places_.resize_uninitialized(job_.row_order.empty() ? 0 : seeds_.size());
    for (std::size_t s = 0; s < row_places_.size(); ++s)
        row_places_[s] = job_.row_order[static_cast<std::size_t>(seeds_.input[s])];
    if (seeds_.duplicates > 0 && job_.duplicates == Duplicates::error) {
        const auto first = std::ranges::find_if(seeds_.duplicate_of, [](auto d) { return d >= 0; });
        const auto index = static_cast<std::size_t>(first - seeds_.duplicate_of.begin());
        const exact::Point place{job_.points[3 * index], job_.points[3 * index + 1], job_.points[3 * index + 2]};
        throw Error(ErrorCode::invalid_argument,
                    "point " + std::to_string(index) + ": " +
                        in_parentheses(std::span(place).first(job_.region.thickness > 0 ? 2 : 3)) +
                        " is a duplicate of point " + std::to_string(*first));
    }
    sorted_ = true;
}

// The heaviest seed of a place has the cell, the first of equal ones. Lighter ones have no cell, equal ones are its
// duplicates.
void CpuClipper::bury_lighter() {
    const auto& weights = job_.domain->weights;
    if (weights.empty()) return;
    auto& duplicate_of = seeds_.duplicate_of;
    if (seeds_.duplicates > 0) {
        std::vector<std::int32_t> heaviest(duplicate_of.size(), -1);  // by the lowest index of a place
        for (std::size_t i = 0; i < duplicate_of.size(); ++i) {
            if (duplicate_of[i] < 0) continue;
            const auto place = static_cast<std::size_t>(duplicate_of[i]);
            auto& best = heaviest[place];
            if (best < 0) best = static_cast<std::int32_t>(place);
            if (weights[i] > weights[static_cast<std::size_t>(best)]) best = static_cast<std::int32_t>(i);
        }
        seeds_.duplicates = 0;
        const auto settle = [&](std::size_t i, std::int32_t best) {
            const bool equal = weights[i] == weights[static_cast<std::size_t>(best)];
            const bool itself = static_cast<std::size_t>(best) == i;
            duplicate_of[i] = equal && !itself ? best : -1;
            if (equal && !itself) ++seeds_.duplicates;
            if (!equal) buried_.push_back(static_cast<std::int32_t>(i));
        };
        for (std::int32_t& i : seeds_.input)
            if (const std::int32_t best = heaviest[static_cast<std::size_t>(i)]; best >= 0) i = best;
        std::vector<std::int32_t> place_of = duplicate_of;
        for (std::size_t i = 0; i < place_of.size(); ++i) {
            if (place_of[i] >= 0)
                settle(i, heaviest[static_cast<std::size_t>(place_of[i])]);
            else if (heaviest[i] >= 0)
                settle(i, heaviest[i]);
        }
        if (seeds_.duplicates == 0) duplicate_of.clear();
    }
}

void CpuClipper::weigh_places() {
    const auto& weights = job_.domain->weights;
    const std::size_t count = seeds_.size();
    if (weights.empty() || count == 0) return;
    seeds_.weights.resize(seeds_.places());
    pool_->run(ceil_div(seeds_.places(), index_task), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * index_task; s < std::min(seeds_.places(), (task + 1) * index_task); ++s) {
            const bool is_image = seeds_.images != nullptr && s < seeds_.images_end && s >= round_up(count, group_size);
            const std::size_t home = is_image ? static_cast<std::size_t>(images_.home(static_cast<std::int32_t>(s)))
                                              : std::min(s, count - 1);  // padding weighs what the last seed weighs
            seeds_.weights[s] = weights[static_cast<std::size_t>(seeds_.input[home])];
        }
    });
}

void CpuClipper::gather_beyond() {
    seeds_.beyond.clear();
    seeds_.lift = {};
    if (job_.beyond.empty()) return;
    if (!seeds_.weights.empty() && seeds_.images == nullptr) seeds_.lift = fit_lift(seeds_);
    seeds_.beyond.reserve(seeds_.size());
    for (const std::int32_t i : seeds_.input) seeds_.beyond.push_back(job_.beyond[static_cast<std::size_t>(i)]);
}

void CpuClipper::set_empty(ResultBuilder& out) {
    if (job_.domain->has_weights()) ensure_sorted();
    std::size_t empty = 0;
    const auto set = [&](std::size_t i, CellStatus status) {
        if (job_.only) i = static_cast<std::size_t>(job_.only->row_of(static_cast<std::int32_t>(i)));
        if (i >= out.arrays().status.size()) return;  // after clip_first(), or not in the subset
        out.set_empty(i, status);
        ++empty;
    };
    for (const std::int32_t i : buried_) set(static_cast<std::size_t>(i), CellStatus::empty);
    for (std::size_t i = 0; i < job_.outside.size(); ++i)
        if (job_.outside[i] == CellStatus::outside) set(i, CellStatus::outside);
    out.count({.empty_cells = empty});
}

void CpuClipper::build_search() {
    if (searchable_) return;
    if (std::exchange(lacks_images_, false)) {
        images_.add(sorter_, *pool_, seeds_);
        weigh_places();
    }
    hierarchy_.build(seeds_, *pool_);
    searchable_ = true;
}

void CpuClipper::ensure_sorted() {
    if (sorted_) return;
    sort();
    sorter_.release_scratch();
}

void CpuClipper::prepare() {
    ensure_sorted();
    build_search();
}

std::span<const std::int32_t> CpuClipper::duplicate_of() {
    ensure_sorted();
    return seeds_.duplicate_of;
}

void CpuClipper::clip_all(ResultBuilder& out, const Share& share) {
    cut_into_blocks(seeds_.size());
    clip_blocks(
        seeds_.input, [](std::size_t k) { return k; }, false, out, share);
}

void CpuClipper::clip_first(std::size_t count, std::span<double> powers, ResultBuilder& out, const Share& share) {
    order_.clear();
    for (std::size_t s = 0; s < seeds_.size(); ++s)
        if (static_cast<std::size_t>(seeds_.input[s]) < count) order_.push_back(static_cast<std::int32_t>(s));
    const std::span<std::int32_t> cells = out.allocate_cells(order_.size());
    std::ranges::transform(order_, cells.begin(), [&](std::int32_t seed) { return seeds_.input[seed]; });
    cut_into_blocks(order_.size());
    powers_ = powers;
    clip_order(cells, false, out, share);
    powers_ = {};
}

void CpuClipper::cut_into_blocks(std::size_t count) {
    const std::size_t threads = pool_->size();
    const bool placed = job_.want.vertices;
    const std::size_t longest = placed ? longest_placed : longest_block;
    std::size_t parts = threads == 1 ? 1 : parts_per_thread * threads;
    if (placed && threads <= many_threads) parts = std::max(fewest_placed, count / longest);
    blocks_.assign(1, 0);
    while (blocks_.back() < count) {
        const std::size_t left = count - blocks_.back();
        const std::size_t size = round_up(std::clamp(left / parts, shortest_block, longest), Star::alignment);
        blocks_.push_back(blocks_.back() + std::min(left, size));
    }
}

void CpuClipper::cut_into_small_blocks(std::size_t count) {
    const bool placed = job_.want.vertices && pool_->size() <= many_threads;
    const std::size_t parts = placed ? few_placed : pool_->size() * blocks_per_thread;
    const std::size_t per_block = std::clamp(count / parts, min_block_seeds, shortest_block);
    blocks_.assign(1, 0);
    while (blocks_.back() < count) blocks_.push_back(std::min(count, blocks_.back() + per_block));
}

void CpuClipper::clip_only(ResultBuilder& out, const Share& share) {
    std::vector<bool> wanted(job_.points.count());
    for (const std::int32_t id : job_.only->ids()) wanted[static_cast<std::size_t>(id)] = true;
    order_.clear();
    for (std::size_t s = 0; s < seeds_.size(); ++s)
        if (wanted[static_cast<std::size_t>(seeds_.input[s])]) order_.push_back(static_cast<std::int32_t>(s));
    const std::span<std::int32_t> rows = out.allocate_cells(order_.size());
    std::ranges::transform(order_, rows.begin(), [&](std::int32_t s) { return row_of(static_cast<std::size_t>(s)); });
    cut_into_small_blocks(rows.size());
    clip_order(rows, false, out, share);
}

void CpuClipper::clip(std::span<const std::int32_t> cells, ResultBuilder& out, const Share& share) {
    if (cells.empty()) return;
    prepare();
    put_in_sorted_order(cells);
    const std::span<std::int32_t> kept = out.allocate_cells(order_.size());
    std::ranges::transform(order_, kept.begin(), [&](std::int32_t seed) { return seeds_.input[seed]; });
    cut_into_small_blocks(kept.size());
    clip_order(kept, true, out, share);
    for (const std::int32_t cell : kept) {
        CellStatus& status = out.arrays().status[static_cast<std::size_t>(cell)];
        if (status != CellStatus::empty) status = CellStatus::certified;
    }
}

void CpuClipper::find_positions() {
    if (positions_known_) return;
    position_.resize_uninitialized(job_.points.count());
    if (seeds_.size() < position_.size()) std::ranges::fill(position_, -1);
    const std::size_t count = seeds_.size();
    pool_->run(ceil_div(count, index_task), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * index_task; s < std::min(count, (task + 1) * index_task); ++s)
            position_[static_cast<std::size_t>(seeds_.input[s])] = static_cast<std::int32_t>(s);
    });
    positions_known_ = true;
}

// Lists the sorted seeds of the cells, ascending, without duplicates. Neighbors in memory share windows and caches.
void CpuClipper::put_in_sorted_order(std::span<const std::int32_t> cells) {
    find_positions();
    auto& order = order_;
    order.clear();
    order.reserve(cells.size());
    for (const std::int32_t cell : cells) {
        const auto i = static_cast<std::size_t>(static_cast<std::uint32_t>(cell));
        if (i >= position_.size()) throw Error(ErrorCode::internal, "cell " + std::to_string(cell) + " does not exist");
        if (position_[i] >= 0) order.push_back(position_[i]);
    }
    if (cells.size() < seeds_.size() / 16) {
        std::sort(order.begin(), order.end());
    } else {  // marking is faster than sorting
        chosen_.assign(seeds_.size(), false);
        for (const std::int32_t seed : order) chosen_[static_cast<std::size_t>(seed)] = true;
        order.clear();
        for (std::size_t seed = 0; seed < chosen_.size(); ++seed)
            if (chosen_[seed]) order.push_back(static_cast<std::int32_t>(seed));
    }
}

CpuClipper::Worker::Worker(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels)
    : builder(seeds, hierarchy, kernels), star(make_star(kernels.name, seeds, hierarchy)), writer(seeds) {}

void CpuClipper::begin_workers(ResultBuilder& out) {
    if (workers_.size() < pool_->size()) {  // each takes some 70 microseconds
        std::vector<std::unique_ptr<Worker>> more(pool_->size() - workers_.size());
        pool_->run(more.size(), [&](std::size_t index, unsigned) {
            more[index] = std::make_unique<Worker>(seeds_, hierarchy_, *kernels_);
        });
        std::ranges::move(more, std::back_inserter(workers_));
    }
    unsigned index = 0;
    for (const auto& worker : workers_) {
        worker->hard.clear();  // of a cancelled job
        worker->builder.begin_job(*job_.domain);
        worker->star->begin_job(*job_.domain);
        worker->writer.begin_job(job_, star_kernels(kernels_->name), row_places_, out);
        worker->writer.keep(kept_, index++);
    }
}

void CpuClipper::end_workers(ResultBuilder& out) const {
    for (const auto& worker : workers_) {
        out.count(worker->writer.counters());
        out.count(worker->writer.tally());
    }
}

template <class SeedAt>
void CpuClipper::clip_blocks(std::span<const std::int32_t> cells, SeedAt seed_at, bool fallback, ResultBuilder& out,
                             const Share& share) {
    begin_workers(out);
    const std::size_t blocks = blocks_.size() - 1;
    const Star::Keep keep = kept_ == nullptr ? kept_for(job_.want) : Star::Keep::corners;
    const Stoppable stoppable(progress_, share);
    const bool walks = seeds_.lift.curvature <= max_walked_curvature;
    const auto task = [&](std::size_t block, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = blocks_[block], end = blocks_[block + 1];
        const std::size_t last = seed_at(end - 1) + 1;
        std::size_t stretch_end = 0;
        worker.budget.begin(end - begin);
        worker.builder.forget_owners();
        worker.hidden = 0;
        for (std::size_t k = begin; k < end; ++k) {
            if (k % cells_per_check == 0) check_stop();
            if (const std::size_t rows = worker.writer.rows(); rows == CellWriter::few_rows)
                worker.writer.end_rows(cells.subspan(k - rows, rows));
            const std::size_t seed = seed_at(k);
            if (seed >= stretch_end) {
                const std::size_t first = seed / Star::alignment * Star::alignment;
                stretch_end = std::min(last, first + std::max(sparse_stretch, end - begin));
                worker.star->begin(first, stretch_end, keep);
                worker.writer.begin_stretch();
            }
            worker.writer.prefetch(seed);
            if (worker.hidden >= hidden_in_a_row && hide(seed, worker)) continue;
            if (!walks || seeds_.is_beyond(seed) || !worker.budget.worth_a_star() || !worker.star->build(seed)) {
                search(seed, worker);
                continue;
            }
            worker.budget.star_done();
            worker.hidden = worker.star->faces().empty() ? worker.hidden + 1 : 0;
            if (worker.writer.write(seed, *worker.star)) {
                if (!powers_.empty()) powers_[seeds_.input[seed]] = worker.star->power_found();
            } else {
                finish(&clip_by_faces(seed, worker), seed, worker);
            }
        }
        worker.writer.end_block(cells.subspan(begin, end - begin));
    };
    pool_->run_stage(blocks, std::cref(task));  // by reference: no allocation
    if (widen_images()) {
        end_workers(out);
        clip_hard_again(out, share);
    } else {
        clip_hard(out);
        end_workers(out);
    }
    if (fallback) out.count({.fallback_cells = cells.size()});
}

void CpuClipper::clip_order(std::span<const std::int32_t> cells, bool fallback, ResultBuilder& out,
                            const Share& share) {
    clip_blocks(
        cells, [this](std::size_t k) { return static_cast<std::size_t>(order_[k]); }, fallback, out, share);
}

// Clips by the faces that the walk has found, for measures that need exact vertices.
Cell& CpuClipper::clip_by_faces(std::size_t seed, Worker& worker) const {
    worker.candidates.clear();
    worker.shifts.clear();
    for (const std::int32_t id : worker.star->faces()) {
        if (id < 0) continue;
        worker.candidates.push_back(seeds_.images == nullptr ? id : images_.home(id));
        if (seeds_.images != nullptr) worker.shifts.push_back(images_.shift(id));
    }
    return build_from_candidates(seed, worker);
}

Cell& CpuClipper::build_from_candidates(std::size_t seed, Worker& worker) const {
    return seeds_.images == nullptr ? worker.builder.build_from(seed, worker.candidates)
                                    : worker.builder.build_from(seed, worker.candidates, worker.shifts);
}

bool CpuClipper::hide(std::size_t seed, Worker& worker) const {
    if (Cell* cell = seeds_.is_beyond(seed) ? nullptr : worker.builder.build_if_hidden(seed); cell != nullptr) {
        finish(cell, seed, worker);
        return true;
    }
    worker.hidden = 0;
    return false;
}

void CpuClipper::search(std::size_t seed, Worker& worker) const {
    const std::size_t tests = worker.budget.tests();
    const bool hidden_only = tests == 0 && !seeds_.weights.empty() && !seeds_.is_beyond(seed);
    Cell* cell = hidden_only ? worker.builder.build_if_hidden(seed) : worker.builder.build(seed, tests);
    worker.hidden = cell != nullptr && cell->empty() ? worker.hidden + 1 : 0;
    // Where the budget is spent, hidden seeds say nothing about the next star.
    worker.budget.searched(worker.builder.tests(), cell != nullptr && tests > 0);
    finish(cell, seed, worker);
}

void CpuClipper::finish(Cell* cell, std::size_t seed, Worker& worker) const {
    if (cell != nullptr) {
        if (!powers_.empty())
            powers_[seeds_.input[seed]] =
                cell->empty()
                    ? Star::min_power
                    : bounds::power(cell->radius_squared(), seeds_.weights.empty() ? 0 : seeds_.weights[seed]);
        const bool placed = job_.want.vertices;
        worker.writer.write(seed, placed ? worker.builder.rebuild(worker.faces) : *cell);
    } else {
        worker.hard.push_back(static_cast<std::int32_t>(seed));
        worker.writer.skip_row();
    }
}

// Makes the polytopes of cells whose neighbors another engine has certified, for measures that it lacks.
void CpuClipper::clip_listed(const NeighborLists& lists, ResultBuilder& out, const Share& share) {
    if (lists.cells.empty()) return;
    ensure_sorted();
    find_positions();
    begin_workers(out);
    const std::size_t count = lists.cells.size(), blocks = ceil_div(count, listed_block);
    const std::span<std::int32_t> cells = out.allocate_cells(count);
    std::ranges::copy(lists.cells, cells.begin());
    std::vector<std::size_t> first_entry(blocks + 1, 0);
    for (std::size_t k = 0; k < count; ++k) first_entry[k / listed_block + 1] += lists.lengths[k];
    for (std::size_t b = 0; b < blocks; ++b) first_entry[b + 1] += first_entry[b];
    const Stoppable stoppable(progress_, share);
    const auto task = [&](std::size_t block, unsigned index) {
        Worker& worker = *workers_[index];
        const std::size_t begin = block * listed_block, end = std::min(count, begin + listed_block);
        std::size_t entry = first_entry[block];
        for (std::size_t k = begin; k < end; ++k) {
            worker.candidates.clear();
            worker.shifts.clear();
            const auto seed = static_cast<std::size_t>(position_[static_cast<std::size_t>(cells[k])]);
            for (const std::size_t row_end = entry + lists.lengths[k]; entry < row_end; ++entry) {
                if (lists.ids[entry] < 0) continue;
                const std::int32_t neighbor = position_[static_cast<std::size_t>(lists.ids[entry])];
                worker.candidates.push_back(neighbor);
                if (lists.shifts.empty()) continue;
                exact::Shift shift = images_.shift_in_domain(neighbor, seed);
                for (std::size_t j = 0; j < 3; ++j) shift[j] = lists.shifts[entry][j] - shift[j];
                worker.shifts.push_back(shift);
            }
            Cell& cell = lists.shifts.empty() ? worker.builder.build_from(seed, worker.candidates)
                                              : worker.builder.build_from(seed, worker.candidates, worker.shifts);
            worker.writer.write(seed, cell);
        }
        worker.writer.end_block(cells.subspan(begin, end - begin));
    };
    pool_->run_stage(blocks, std::cref(task));
    end_workers(out);
}

}  // namespace votess::cpu
