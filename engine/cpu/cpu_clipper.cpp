#include "cpu/cpu_clipper.hpp"

#include <algorithm>
#include <thread>

#include "options.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t block_seeds = 2048;      // per task: neighbors in space, which share what they find
constexpr std::size_t least_block_seeds = 16;  // of few cells, so that all threads get some
constexpr std::size_t blocks_per_thread = 8;
constexpr std::size_t index_task = 65536;  // entries of the inverse order per parallel task

std::size_t blocks_for(std::size_t count, std::size_t per_block) {
    return (count + per_block - 1) / per_block;
}

}  // namespace

void CpuClipper::begin(const Job& job) {
    end();
    job_ = job;
    progress_ = Progress(job.options.progress);
    const unsigned hardware = std::max(1u, std::thread::hardware_concurrency());
    const unsigned threads = job.options.threads == 0 ? hardware : job.options.threads;
    if (!pool_ || pool_->size() != threads) pool_.emplace(threads);
}

void CpuClipper::end() {
    workers_.clear();  // refer to the seeds
    delaunay_.reset();
    position_.clear();
    sorted_ = searchable_ = false;
    progress_ = {};
    job_ = {};
}

void CpuClipper::sort() {
    if (sorted_) return;
    const unsigned resolution = job_.options.grid_resolution;
    if (job_.points.f32.empty())
        sorter_.sort(job_.points.f64, job_.scale, resolution, *pool_, seeds_);
    else
        sorter_.sort(job_.points.f32, job_.scale, resolution, *pool_, seeds_);
    if (seeds_.duplicates > 0 && job_.options.duplicates == Duplicates::error) {
        const auto first = std::ranges::find_if(seeds_.duplicate_of, [](auto d) { return d >= 0; });
        const auto index = static_cast<std::size_t>(first - seeds_.duplicate_of.begin());
        throw Error(ErrorCode::invalid_argument,
                    "point " + std::to_string(index) + ": (" + number(job_.points[3 * index]) + ", " +
                        number(job_.points[3 * index + 1]) + ", " + number(job_.points[3 * index + 2]) +
                        ") is a duplicate of point " + std::to_string(*first));
    }
    sorted_ = true;
}

void CpuClipper::build_search() {
    if (searchable_) return;
    hierarchy_.build(seeds_, *pool_);
    searchable_ = true;
}

void CpuClipper::prepare() {
    sort();
    build_search();
}

std::span<const std::int32_t> CpuClipper::duplicate_of() {
    sort();
    return seeds_.duplicate_of;
}

void CpuClipper::clip_all(ResultBuilder& out, const Stretch& stretch) {
    clip_blocks(
        seeds_.input, block_seeds, [](std::size_t k) { return k; }, false, out, stretch);
}

void CpuClipper::clip(std::span<const std::int32_t> cells, ResultBuilder& out, const Stretch& stretch) {
    if (cells.empty()) return;
    prepare();
    const std::vector<std::int32_t> order = in_sorted_order(cells);
    std::vector<std::int32_t> inputs(order.size());
    std::ranges::transform(order, inputs.begin(), [&](std::int32_t seed) { return seeds_.input[seed]; });
    const std::span<const std::int32_t> kept = out.keep(std::move(inputs));
    const std::size_t per_block =
        std::clamp(order.size() / (pool_->size() * blocks_per_thread), least_block_seeds, block_seeds);
    clip_blocks(
        kept, per_block, [&](std::size_t k) { return static_cast<std::size_t>(order[k]); }, true, out, stretch);
    for (const std::int32_t cell : kept) out.status()[static_cast<std::size_t>(cell)] = CellStatus::certified;
}

// Their sorted seeds, ascending, without duplicates: neighbors in memory share windows and caches.
std::vector<std::int32_t> CpuClipper::in_sorted_order(std::span<const std::int32_t> cells) {
    if (position_.empty()) {
        position_.assign(job_.points.count(), -1);
        const std::size_t count = seeds_.size();
        pool_->run(blocks_for(count, index_task), [&](std::size_t task, unsigned) {
            for (std::size_t s = task * index_task; s < std::min(count, (task + 1) * index_task); ++s)
                position_[static_cast<std::size_t>(seeds_.input[s])] = static_cast<std::int32_t>(s);
        });
    }
    std::vector<std::int32_t> order;
    order.reserve(cells.size());
    for (const std::int32_t cell : cells) {
        const auto i = static_cast<std::size_t>(static_cast<std::uint32_t>(cell));
        if (i >= position_.size()) throw Error(ErrorCode::internal, "cell " + std::to_string(cell) + " does not exist");
        if (position_[i] >= 0) order.push_back(position_[i]);
    }
    if (cells.size() < seeds_.size() / 16) {
        std::sort(order.begin(), order.end());
    } else {  // marking is faster than sorting
        std::vector<bool> chosen(seeds_.size());
        for (const std::int32_t seed : order) chosen[static_cast<std::size_t>(seed)] = true;
        order.clear();
        for (std::size_t seed = 0; seed < chosen.size(); ++seed)
            if (chosen[seed]) order.push_back(static_cast<std::int32_t>(seed));
    }
    return order;
}

template <class SeedAt>
void CpuClipper::clip_blocks(std::span<const std::int32_t> cells, std::size_t block_cells, SeedAt seed_at,
                             bool fallback, ResultBuilder& out, const Stretch& stretch) {
    if (workers_.empty()) workers_ = std::vector<Worker>(pool_->size());
    for (Worker& worker : workers_) worker.counters = {};
    const std::size_t blocks = blocks_for(cells.size(), block_cells);
    const bool measure = job_.options.want.volumes || job_.options.want.centroids;
    ThreadPool::Watch watch;
    if (progress_) watch = [&](std::size_t done) { return progress_.going_on(stretch.at(done, blocks)); };
    const bool finished = pool_->run(
        blocks,
        [&](std::size_t block, unsigned index) {
            Worker& worker = workers_[index];
            if (!worker.star) {
                worker.builder.emplace(seeds_, hierarchy_, job_.scaled_box);
                worker.kernels = &star_kernels(best_kernels().name);
                worker.star = make_star(best_kernels().name, seeds_, hierarchy_, job_.scaled_box);
            }
            worker.rows.clear();
            worker.lengths.clear();
            const std::size_t begin = block * block_cells;
            const std::size_t end = std::min(cells.size(), begin + block_cells);
            worker.budget.begin(end - begin);
            const std::size_t last = seed_at(end - 1) + 1;
            std::size_t stretch_end = 0;
            for (std::size_t k = begin; k < end; ++k) {
                const std::size_t seed = seed_at(k);
                if (seed >= stretch_end) {
                    const std::size_t first = seed / group_size * group_size;
                    stretch_end = std::min(last, first + Star::most_seeds);
                    worker.star->begin(first, stretch_end, measure);
                }
                if (worker.budget.worth_a_star() && build_star(seed, worker, out))
                    worker.budget.star_done();
                else
                    clip_seed(seed, worker, out);
            }
            out.add_rows(cells.subspan(begin, end - begin), worker.lengths, {worker.rows.begin(), worker.rows.end()});
        },
        watch);
    Progress::require(finished);
    clip_hard(out, stretch);
    for (const Worker& worker : workers_) out.count(worker.counters);
    if (fallback) out.count({.fallback_cells = cells.size()});
}

bool CpuClipper::build_star(std::size_t seed, Worker& worker, ResultBuilder& out) const {
    const Want& want = job_.options.want;
    Star& star = *worker.star;
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    // Results go to the places of the input, which are anywhere in memory.
    if (want.volumes) __builtin_prefetch(&out.volumes()[input], 1);
    if (want.centroids) __builtin_prefetch(&out.centroids()[3 * input], 1);
    if (!star.build(seed)) return false;
    if (want.volumes || want.centroids) {
        Star::Geometry geometry;
        if (!star.measure(geometry)) return false;
        const double unscale = 1 / job_.scale;
        if (want.volumes) out.volumes()[input] = geometry.volume * unscale * unscale * unscale;
        if (want.centroids) {
            const double p[3] = {seeds_.x[seed], seeds_.y[seed], seeds_.z[seed]};
            for (int k = 0; k < 3; ++k) out.centroids()[3 * input + k] = (geometry.centroid[k] + p[k]) * unscale;
        }
    }
    const auto faces = star.faces();
    worker.counters.faces += faces.size();
    worker.counters.exact_cells += star.used_exact() ? 1 : 0;
    if (want.neighbors) {
        std::array<std::int32_t, most_row> ids;
        int count = 0;
        for (const std::int32_t id : faces) {
            ids[count] = id < 0 ? id : seeds_.input[id];
            count += (id >= 0 || job_.options.walls) ? 1 : 0;
        }
        const std::size_t at = worker.rows.size();
        worker.rows.resize(at + most_row);
        worker.kernels->sort_row(ids.data(), count, worker.rows.data() + at);
        worker.rows.resize(at + static_cast<std::size_t>(count));
        worker.lengths.push_back(static_cast<std::uint32_t>(count));
    }
    if (want.counts) {
        out.face_counts()[input] = static_cast<std::uint32_t>(faces.size());
        out.edge_counts()[input] = static_cast<std::uint32_t>(star.edge_count());
        out.vertex_counts()[input] = static_cast<std::uint32_t>(star.vertex_count());
    }
    return true;
}

void CpuClipper::clip_seed(std::size_t seed, Worker& worker, ResultBuilder& out) const {
    Cell* cell = worker.builder->build(seed, worker.budget.tests());
    worker.budget.searched(worker.builder->tests(), cell != nullptr);
    if (cell != nullptr) {
        store(*cell, seed, worker, out);
    } else {
        worker.hard.push_back(static_cast<std::int32_t>(seed));
        if (job_.options.want.neighbors) worker.lengths.push_back(0);  // its row comes later
    }
}

void CpuClipper::store(Cell& found, std::size_t seed, Worker& worker, ResultBuilder& out) const {
    const Want& want = job_.options.want;
    const bool used_exact = found.used_exact();
    Cell& cell = want.volumes || want.centroids ? worker.builder->again(worker.faces) : found;
    const auto input = static_cast<std::size_t>(seeds_.input[seed]);
    const bool need_polygons = want.volumes || want.centroids || want.counts || cell.met_tie();
    std::span<const std::int32_t> planes;
    if (need_polygons) {
        cell.canonical_faces(worker.faces);
        planes = worker.faces.planes;
    } else {
        cell.face_planes(worker.planes);
        planes = worker.planes;
    }
    worker.counters.faces += planes.size();
    worker.counters.exact_cells += used_exact ? 1 : 0;
    if (want.neighbors) {
        auto& row = worker.row;
        row.clear();
        for (const std::int32_t p : planes) {
            const std::int32_t id = cell.planes()[p].id;
            if (id >= 0)
                row.push_back(seeds_.input[id]);
            else if (job_.options.walls)
                row.push_back(id);
        }
        std::sort(row.begin(), row.end());
        worker.rows.insert(worker.rows.end(), row.begin(), row.end());
        worker.lengths.push_back(static_cast<std::uint32_t>(row.size()));
    }
    if (want.volumes || want.centroids) {
        const CellGeometry geometry = cell.measure(worker.faces);
        const double unscale = 1 / job_.scale;
        if (want.volumes) out.volumes()[input] = geometry.volume * unscale * unscale * unscale;
        if (want.centroids)
            for (int k = 0; k < 3; ++k)
                out.centroids()[3 * input + k] = (geometry.centroid[k] + cell.seed()[k]) * unscale;
    }
    if (want.counts) {
        out.face_counts()[input] = static_cast<std::uint32_t>(planes.size());
        out.edge_counts()[input] = worker.faces.edge_count;
        out.vertex_counts()[input] = worker.faces.vertex_count;
    }
}

}  // namespace votess::cpu
