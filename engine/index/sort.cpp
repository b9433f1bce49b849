#include "index/sort.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <functional>
#include <limits>
#include <utility>

#include "core/arithmetic.hpp"

namespace votess::cpu {
namespace {

constexpr std::size_t bucket_seeds = 512;  // desired seeds in a bucket: the records fit the first-level cache
constexpr int max_bucket_bits = 12;        // scattering to more buckets is slow
// A bucket with more seeds than count / 32 is split, clamped to this range: many buckets for all threads, each in the
// second-level cache. Clouds above 33 million seeds may have larger buckets.
constexpr std::size_t crowded_min = 4096;
constexpr std::size_t crowded_max = 32768;
constexpr std::size_t chunk_seeds = 16384;  // minimum in a parallel task
constexpr std::size_t chunks_per_thread = 4;
constexpr std::size_t bucket_task = 1024;  // buckets in a parallel task
constexpr std::size_t sort_task = 8192;    // seeds in a parallel task
constexpr std::size_t ordered_task = 8192;

static_assert(std::bit_width(crowded_min / bucket_seeds) >= 3, "a split has to separate octants");

constexpr std::int32_t not_split = -1;
constexpr std::int32_t one_point = -2;  // cannot be split

// Runs tasks without allocation.
template <class Task>
void run(ThreadPool& pool, std::size_t count, const Task& task) {
    pool.run(count, std::cref(task));
}

}  // namespace

// Calls task(chunk, begin, end) for the parts of 0 .. count - 1.
template <class Task>
void SeedSorter::for_chunks(ThreadPool& pool, std::size_t count, const Task& task) const {
    run(pool, chunks_,
        [&](std::size_t chunk, unsigned) { task(chunk, count * chunk / chunks_, count * (chunk + 1) / chunks_); });
}

template <class Real>
struct SeedSorter::Cloud {
    const Real* points;
    std::size_t count;
    double scale;

    [[nodiscard]] std::array<double, 3> operator[](std::size_t i) const {
        const Real* p = points + 3 * i;
        // Processors stop prefetching at the end of a page.
        __builtin_prefetch(reinterpret_cast<const char*>(p) + 2048);
        return {p[0] * scale, p[1] * scale, p[2] * scale};
    }
};

void SeedSorter::sort(std::span<const double> points, double scale, unsigned resolution, ThreadPool& pool,
                      SortedSeeds& out) {
    sort_cloud(Cloud<double>{points.data(), points.size() / 3, scale}, resolution, pool, out);
}

void SeedSorter::sort(std::span<const float> points, double scale, unsigned resolution, ThreadPool& pool,
                      SortedSeeds& out) {
    sort_cloud(Cloud<float>{points.data(), points.size() / 3, scale}, resolution, pool, out);
}

template <class Real>
void SeedSorter::sort_cloud(const Cloud<Real>& cloud, unsigned resolution, ThreadPool& pool, SortedSeeds& out) {
    const std::size_t count = cloud.count;
    const std::size_t padded = round_up(count, group_size);
    for (auto* v : {&out.x, &out.y, &out.z}) v->resize_uninitialized(padded);
    out.input.resize_uninitialized(count);
    out.duplicate_of.clear();
    out.duplicates = 0;
    if (count == 0) return;
    // Otherwise threads would meet in huge pages, and each clear them.
    for (auto* v : {&out.x, &out.y, &out.z}) v->touch(0, padded, pool);

    chunks_ = pool.size() == 1 ? 1 : std::clamp<std::size_t>(count / chunk_seeds, 1, pool.size() * chunks_per_thread);
    splits_.clear();
    split_of_.clear();
    const int levels =
        resolution == 0 ? Grid::max_levels : std::clamp<int>(std::bit_width(resolution - 1), 1, Grid::max_levels);
    add_split(measure(cloud, pool), levels, count);
    // x holds the keys until the coordinates are written.
    Buffer<double>& keys = out.x;
    make_keys(cloud, pool, keys);
    count_buckets(pool);
    while (split_crowded(cloud, pool, keys)) count_buckets(pool);

    filled_.clear();
    std::uint32_t begin = 0;
    order_buckets(splits_[0], begin);
    if (count > records_.size()) records_.resize_uninitialized(count);
    records_.touch(0, count, pool);
    scatter(cloud, pool, keys);
    sort_buckets(pool, out);
    if (out.duplicates > 0) remove_duplicates(count, pool, out);
    // Padding is infinitely far away, so that the last group is full.
    for (auto* v : {&out.x, &out.y, &out.z}) v->resize_uninitialized(round_up(out.size(), group_size));
    for (auto* v : {&out.x, &out.y, &out.z})
        std::fill(v->begin() + out.size(), v->end(), std::numeric_limits<double>::infinity());
}

template <class Real>
Bounds SeedSorter::measure(const Cloud<Real>& cloud, ThreadPool& pool) {
    bounds_.assign(chunks_, {});
    for_chunks(pool, cloud.count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        Bounds bounds;
        for (std::size_t i = begin; i < end; ++i) {
            const auto [x, y, z] = cloud[i];
            bounds.add(x, y, z);
        }
        bounds_[chunk] = bounds;
    });
    for (std::size_t chunk = 1; chunk < chunks_; ++chunk) bounds_[0].unite(bounds_[chunk]);
    return bounds_[0];
}

void SeedSorter::add_split(const Bounds& bounds, int levels, std::size_t seeds) {
    const bool divisible = bounds.longest() > 0;
    int bits = static_cast<int>(std::bit_width(seeds / bucket_seeds));
    bits = divisible ? std::clamp(bits, 0, std::min(max_bucket_bits, 3 * levels)) : 0;
    const auto first = static_cast<std::uint32_t>(split_of_.size());
    splits_.push_back({Grid(bounds, levels), 3 * levels - bits, first, 1u << bits});
    split_of_.resize(first + (std::size_t{1} << bits), divisible ? not_split : one_point);
}

template <class Real>
void SeedSorter::make_keys(const Cloud<Real>& cloud, ThreadPool& pool, Buffer<double>& keys) {
    const std::size_t buckets = split_of_.size();
    counts_.resize_uninitialized(chunks_ * buckets);
    for_chunks(pool, cloud.count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        const Split split = splits_[0];
        std::uint32_t* counts = &counts_[chunk * buckets];
        std::fill_n(counts, buckets, 0);
        for (std::size_t i = begin; i < end; ++i) {
            const auto [x, y, z] = cloud[i];
            const std::uint64_t key = split.grid.key(x, y, z);
            const std::uint64_t bucket = key >> split.shift;
            ++counts[bucket];
            keys[i] = std::bit_cast<double>(bucket << 32 | key);
        }
    });
}

// Gives each crowded bucket its own grid. Returns false if none is crowded.
template <class Real>
bool SeedSorter::split_crowded(const Cloud<Real>& cloud, ThreadPool& pool, Buffer<double>& keys) {
    const std::size_t crowded = std::clamp(cloud.count / 32, crowded_min, std::max(crowded_max, cloud.count / 1024));
    const std::size_t first_split = splits_.size();
    std::size_t next_split = first_split;
    crowded_.clear();
    for (std::size_t b = 0; b < split_of_.size(); ++b)
        if (totals_[b] > crowded && split_of_[b] == not_split) {
            split_of_[b] = static_cast<std::int32_t>(next_split++);
            crowded_.push_back(totals_[b]);
        }
    if (crowded_.empty()) return false;

    const auto split_of = [&](double key) { return split_of_[std::bit_cast<std::uint64_t>(key) >> 32]; };
    bounds_.assign(chunks_ * crowded_.size(), {});
    for_chunks(pool, cloud.count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        Bounds* bounds = &bounds_[chunk * crowded_.size()];
        for (std::size_t i = begin; i < end; ++i)
            if (const std::int32_t s = split_of(keys[i]); s >= 0) {
                const auto [x, y, z] = cloud[i];
                bounds[static_cast<std::size_t>(s) - first_split].add(x, y, z);
            }
    });
    for (std::size_t c = 0; c < crowded_.size(); ++c) {
        for (std::size_t chunk = 1; chunk < chunks_; ++chunk) bounds_[c].unite(bounds_[chunk * crowded_.size() + c]);
        add_split(bounds_[c], Grid::max_levels, crowded_[c]);
    }

    const std::size_t buckets = split_of_.size();
    counts_.resize_uninitialized(chunks_ * buckets);
    for_chunks(pool, cloud.count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::uint32_t* counts = &counts_[chunk * buckets];
        std::fill_n(counts, buckets, 0);
        for (std::size_t i = begin; i < end; ++i) {
            if (const std::int32_t s = split_of(keys[i]); s >= 0) {
                const Split& split = splits_[static_cast<std::size_t>(s)];
                const auto [x, y, z] = cloud[i];
                const std::uint64_t key = split.grid.key(x, y, z);
                const std::uint64_t bucket = split.first_bucket + (key >> split.shift);
                keys[i] = std::bit_cast<double>(bucket << 32 | key);
            }
            ++counts[std::bit_cast<std::uint64_t>(keys[i]) >> 32];
        }
    });
    return true;
}

// Sums over chunks. Each count becomes the number of seeds that earlier chunks put into the bucket.
void SeedSorter::count_buckets(ThreadPool& pool) {
    const std::size_t buckets = split_of_.size();
    totals_.resize(buckets);
    run(pool, ceil_div(buckets, bucket_task), [&](std::size_t task, unsigned) {
        const std::size_t begin = task * bucket_task, end = std::min(buckets, begin + bucket_task);
        std::fill(totals_.begin() + begin, totals_.begin() + end, 0);
        for (std::size_t chunk = 0; chunk < chunks_; ++chunk)
            for (std::size_t b = begin; b < end; ++b)
                totals_[b] += std::exchange(counts_[chunk * buckets + b], totals_[b]);
    });
}

// Lists buckets along the curve, the parts of a split bucket in its place.
void SeedSorter::order_buckets(const Split& split, std::uint32_t& begin) {
    for (std::uint32_t b = split.first_bucket; b < split.first_bucket + split.buckets; ++b) {
        const std::uint32_t count = totals_[b];
        totals_[b] = begin;
        if (split_of_[b] >= 0) {
            order_buckets(splits_[static_cast<std::size_t>(split_of_[b])], begin);
        } else if (count > 0) {
            filled_.push_back({begin, count, split_of_[b] == one_point});
            begin += count;
        }
    }
}

template <class Real>
void SeedSorter::scatter(const Cloud<Real>& cloud, ThreadPool& pool, const Buffer<double>& keys) {
    const std::size_t buckets = split_of_.size();
    for_chunks(pool, cloud.count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::uint32_t* next = &counts_[chunk * buckets];
        for (std::size_t b = 0; b < buckets; ++b) next[b] += totals_[b];
        const auto key_at = [&](std::size_t i) { return std::bit_cast<std::uint64_t>(keys[i]); };
        for (std::size_t i = begin; i < end; ++i) {
            // The processor cannot predict this address.
            __builtin_prefetch(&records_[next[key_at(std::min(i + 16, end - 1)) >> 32]], 1);
            const auto [x, y, z] = cloud[i];
            const std::uint64_t key = key_at(i);
            records_[next[key >> 32]++] = {x, y, z, static_cast<std::int32_t>(i), static_cast<std::uint32_t>(key)};
        }
    });
}

void SeedSorter::sort_buckets(ThreadPool& pool, SortedSeeds& out) {
    std::size_t most = 0;
    for (const Bucket& s : filled_)
        if (!s.one_point) most = std::max<std::size_t>(most, s.count);
    workers_.resize(pool.size());
    for (BlockSorter& worker : workers_) worker.reserve(most);
    std::atomic<std::size_t> duplicates = 0;
    run(pool, ceil_div(out.input.size(), sort_task), [&](std::size_t task, unsigned worker) {
        const auto at = [&](std::size_t begin) { return std::ranges::lower_bound(filled_, begin, {}, &Bucket::begin); };
        std::size_t dropped = 0;
        for (auto s = at(task * sort_task), end = at((task + 1) * sort_task); s != end; ++s) {
            const std::span<const SeedRecord> records(&records_[s->begin], s->count);
            dropped += s->one_point ? BlockSorter::drop_all_but_first(records, out, s->begin)
                                    : workers_[worker].sort(records, out, s->begin);
        }
        if (dropped > 0) duplicates += dropped;
    });
    out.duplicates = duplicates;
}

// Closes the gaps of dropped seeds. The records serve as scratch.
void SeedSorter::remove_duplicates(std::size_t count, ThreadPool& pool, SortedSeeds& out) {
    out.duplicate_of.assign(count, -1);
    kept_.assign(chunks_ + 1, 0);
    for_chunks(pool, count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::size_t kept = 0;
        for (std::size_t s = begin; s < end; ++s) {
            if (out.input[s] >= 0)
                ++kept;
            else
                out.duplicate_of[static_cast<std::size_t>(dropped(out.input[s]))] = static_cast<std::int32_t>(out.x[s]);
        }
        kept_[chunk + 1] = kept;
    });
    for (std::size_t chunk = 0; chunk < chunks_; ++chunk) kept_[chunk + 1] += kept_[chunk];
    for_chunks(pool, count, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
        std::size_t to = kept_[chunk];
        for (std::size_t s = begin; s < end; ++s)
            if (out.input[s] >= 0) records_[to++] = {out.x[s], out.y[s], out.z[s], out.input[s], 0};
    });
    const std::size_t kept = kept_[chunks_];
    for_chunks(pool, kept, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t s = begin; s < end; ++s) {
            const SeedRecord& r = records_[s];
            out.x[s] = r.x, out.y[s] = r.y, out.z[s] = r.z;
            out.input[s] = r.input;
        }
    });
    for (auto* v : {&out.x, &out.y, &out.z}) v->resize_uninitialized(round_up(kept, group_size));
    out.input.resize_uninitialized(kept);
}

void sort_inside(const Points& points, double scale, unsigned resolution, std::span<const CellStatus> outside,
                 SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    if (outside.empty()) {
        if (points.f32.empty())
            sorter.sort(points.f64, scale, resolution, pool, out);
        else
            sorter.sort(points.f32, scale, resolution, pool, out);
        return;
    }
    std::vector<double> kept;
    std::vector<std::int32_t> input;  // of those kept
    for (std::size_t i = 0; i < outside.size(); ++i) {
        if (outside[i] == CellStatus::outside) continue;
        for (std::size_t k = 0; k < 3; ++k) kept.push_back(points[3 * i + k]);
        input.push_back(static_cast<std::int32_t>(i));
    }
    sorter.sort(kept, scale, resolution, pool, out);
    for (std::int32_t& i : out.input) i = input[static_cast<std::size_t>(i)];
    if (out.duplicates == 0) return;
    std::vector<std::int32_t> duplicate_of(points.count(), -1);
    for (std::size_t i = 0; i < input.size(); ++i)
        if (const std::int32_t first = out.duplicate_of[i]; first >= 0)
            duplicate_of[static_cast<std::size_t>(input[i])] = input[static_cast<std::size_t>(first)];
    out.duplicate_of = std::move(duplicate_of);
}

void put_in_order(const Points& points, double scale, std::span<const std::int32_t> order, ThreadPool& pool,
                  SortedSeeds& out) {
    const std::size_t count = order.size();
    out.input.resize_uninitialized(count);
    out.duplicate_of.clear();
    out.duplicates = 0;
    Buffer<double>* const axes[3] = {&out.x, &out.y, &out.z};
    for (auto* axis : axes) {
        axis->resize_uninitialized(round_up(count, group_size));
        std::fill(axis->begin() + count, axis->end(), std::numeric_limits<double>::infinity());
    }
    pool.run(ceil_div(count, ordered_task), [&](std::size_t task, unsigned) {
        for (std::size_t s = task * ordered_task; s < std::min(count, (task + 1) * ordered_task); ++s) {
            const auto i = static_cast<std::size_t>(out.input[s] = order[s]);
            for (std::size_t k = 0; k < 3; ++k) (*axes[k])[s] = points[3 * i + k] * scale;
        }
    });
}

}  // namespace votess::cpu
