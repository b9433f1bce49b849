// Sorts seeds so that memory order follows space. They are binned in a grid whose blocks follow a Hilbert curve. A
// crowded block is binned again within its own bounds. Equal seeds always share a block, so duplicates are found.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "index/sort_block.hpp"
#include "index/sort_grid.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"

namespace votess::cpu {

// Scatters the seeds into buckets that fit a cache and sorts each bucket. Needs 36 bytes a seed, keeps the addresses,
// and releases the pages of large buffers.
class SeedSorter {
public:
    // points: 3N; each coordinate is multiplied by `scale`, a power of two. resolution: grid blocks along the longest
    // axis, 1 to 1024 (more count as 1024), 0 = automatic. Reuses the memory of `out`. The order does not depend on the
    // number of threads.
    void sort(std::span<const double> points, double scale, unsigned resolution, ThreadPool& pool, SortedSeeds& out);
    void sort(std::span<const float> points, double scale, unsigned resolution, ThreadPool& pool, SortedSeeds& out);
    // Returns memory that is free until the next sort.
    [[nodiscard]] std::span<std::byte> scratch() { return records_.memory(); }
    // Returns it to the system if it is large.
    void release_scratch() { records_.release_pages(); }

private:
    template <class Real>
    struct Cloud;
    struct Split {
        Grid grid;
        int shift;  // from a key to its bucket
        std::uint32_t first_bucket, buckets;
    };
    struct Bucket {  // nonempty bucket in the order of the curve
        std::uint32_t begin, count;
        bool one_point;
    };

    template <class Task>
    void for_chunks(ThreadPool& pool, std::size_t count, const Task& task) const;
    template <class Real>
    void sort_cloud(const Cloud<Real>& cloud, unsigned resolution, ThreadPool& pool, SortedSeeds& out);
    template <class Real>
    [[nodiscard]] Bounds measure(const Cloud<Real>& cloud, ThreadPool& pool);
    void add_split(const Bounds& bounds, int levels, std::size_t seeds);
    template <class Real>
    void make_keys(const Cloud<Real>& cloud, ThreadPool& pool, Buffer<double>& keys);
    template <class Real>
    [[nodiscard]] bool split_crowded(const Cloud<Real>& cloud, ThreadPool& pool, Buffer<double>& keys);
    void count_buckets(ThreadPool& pool);
    void order_buckets(const Split& split, std::uint32_t& begin);
    template <class Real>
    void scatter(const Cloud<Real>& cloud, ThreadPool& pool, const Buffer<double>& keys);
    void sort_buckets(ThreadPool& pool, SortedSeeds& out);
    void remove_duplicates(std::size_t count, ThreadPool& pool, SortedSeeds& out);

    // The input is cut in chunks, one task each.
    std::size_t chunks_ = 1;
    std::vector<Bounds> bounds_;          // by chunk, and by crowded bucket
    std::vector<Split> splits_;           // the first is of all seeds
    std::vector<std::int32_t> split_of_;  // by bucket: its split, or a negative number
    Buffer<std::uint32_t> counts_;        // by chunk and bucket; later the next place to write
    std::vector<std::uint32_t> totals_;   // by bucket: seeds; later its begin
    std::vector<std::size_t> crowded_;    // seeds in each bucket that is being split
    std::vector<Bucket> filled_;
    Buffer<SeedRecord> records_{Buffer<SeedRecord>::Pages::huge};
    std::vector<BlockSorter> workers_;
    std::vector<std::size_t> kept_;  // by chunk
};

// Sorts the seeds of a job that have a cell. outside: as in the job. Indices in `out` are those of the points. See
// SeedSorter::sort() for the rest.
void sort_inside(const Points& points, double scale, unsigned resolution, std::span<const CellStatus> outside,
                 SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out);

// Puts all seeds in the order of an earlier sort instead. They must differ.
void put_in_order(const Points& points, double scale, std::span<const std::int32_t> order, ThreadPool& pool,
                  SortedSeeds& out);

}  // namespace votess::cpu
