// Clips cells on the CPU: all of them for the CPU engine, or some for another engine.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "core/buffer.hpp"
#include "cpu/cell_builder.hpp"
#include "cpu/hard_cells.hpp"
#include "follow/kept_cells.hpp"
#include "index/seed_images.hpp"
#include "index/sort.hpp"
#include "output/cell_writer.hpp"
#include "output/exact_clipper.hpp"
#include "triangulate/delaunay.hpp"
#include "walk/star.hpp"

namespace votess::cpu {

class CpuClipper : public ExactClipper {
public:
    void begin(const Job& job) override;
    // Makes the pool of so many threads, 0 = one for each processor, unless it exists.
    ThreadPool& pool_of(unsigned threads);
    // Gets new threads in a child made by fork().
    ThreadPool& pool() override {
        if (!pool_->has_threads()) pool_.emplace(pool_->requested());
        return *pool_;
    }
    void prepare() override;
    std::span<const std::int32_t> duplicate_of() override;
    [[nodiscard]] bool has_cell(std::int32_t cell) const override {
        return position_[static_cast<std::size_t>(cell)] >= 0;
    }
    void clip(std::span<const std::int32_t> cells, ResultBuilder& out, const Share& share) override;
    void set_empty(ResultBuilder& out) override;
    void clip_listed(const NeighborLists& lists, ResultBuilder& out, const Share& share) override;
    void end() override;

    // Valid for the job, until end().
    [[nodiscard]] Progress& progress() { return progress_; }
    // For queries, after prepare().
    [[nodiscard]] const SortedSeeds& seeds() const { return seeds_; }
    [[nodiscard]] const Hierarchy& hierarchy() const { return hierarchy_; }

    // Which seeds of a power diagram sort() keeps: all; none that are surely buried; all unless most are.
    enum class Keep { all, unburied, all_unless_most };
    // The stages of a full run, in this order. order: of an earlier sort of all seeds, to be used again, or none.
    void sort(std::span<const std::int32_t> order = {}, Keep keep = Keep::all);
    void build_search();
    void clip_all(ResultBuilder& out, const Share& share);
    // Stores the following cells of clip_all() and clip_kept(); null: no more.
    void keep(KeptCells* kept) { kept_ = kept; }
    [[nodiscard]] std::string_view instructions() const { return kernels_->name; }
    // Whether cells need the points, for the rounding errors of wrapped coordinates.
    [[nodiscard]] bool reads_points() const { return seeds_.images != nullptr && images_.any_wrapped(); }
    // Whether all points of the job are sorted seeds.
    [[nodiscard]] bool all_differ() const {
        return seeds_.size() + static_cast<std::size_t>(std::ranges::count(job_.outside, CellStatus::outside)) ==
               job_.points.count();
    }
    [[nodiscard]] const SortedSeeds& sorted() const { return seeds_; }
    // Replaces clip_all(): tests the kept cells and makes those that do not hold. Returns false if that would not pay
    // or the seeds are not like those of the last call; the result must then begin again. ready() is called before
    // kept cells are written, when nothing else can fail.
    [[nodiscard]] bool clip_kept(ResultBuilder& out, const Share& share, const std::function<void()>& ready);
    // Stores the cells of the sample.
    void keep_sample(ResultBuilder& out);
    // Replaces clip_all(): makes the cells of the job's subset.
    void clip_only(ResultBuilder& out, const Share& share);
    // After another call: makes cells of the same seeds. job: with another want, and a subset.
    void clip_more(const Job& job, ResultBuilder& out, const Share& share) {
        job_ = job;
        clip_only(out, share);
    }
    // Replaces clip_all(): makes the cells of the first `count` points of the job, those of the result. The other
    // points are only neighbors. powers: by cell, Star::power_found(), or the power of all vertices of a clipped cell.
    void clip_first(std::size_t count, std::span<double> powers, ResultBuilder& out, const Share& share);
    // Lends the sorter's scratch to the rows, from sort() to the end of the job.
    void lend_scratch(ResultBuilder& out) { out.lend(sorter_.scratch()); }
    // Lends the seeds. Call when no more cells are needed.
    void lend_seeds(ResultBuilder& out);

private:
    struct Worker {  // scratch of one thread
        Worker(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels);

        CellBuilder builder;
        std::unique_ptr<Star> star;
        CellWriter writer;
        SearchBudget budget;
        std::size_t hidden = 0;          // seeds without a cell since the last with one
        std::vector<std::int32_t> hard;  // sorted seeds whose search was given up
        std::vector<std::int32_t> candidates;
        std::vector<std::uint8_t> marks;  // of Delaunay::neighbors()
        std::vector<exact::Shift> shifts;
        CellFaces faces;
    };

    // For jobs that are not full runs.
    void ensure_sorted();
    void bury_lighter();
    void weigh_places();
    void gather_beyond();
    void begin_workers(ResultBuilder& out);
    void end_workers(ResultBuilder& out) const;
    void find_positions();
    void put_in_sorted_order(std::span<const std::int32_t> cells);
    void cut_into_blocks(std::size_t count);
    // Cuts few cells, so that all threads get some.
    void cut_into_small_blocks(std::size_t count);
    // Returns the row of a sorted seed.
    [[nodiscard]] std::int32_t row_of(std::size_t seed) const {
        const std::int32_t input = seeds_.input[seed];
        return job_.only ? job_.only->row_of(input) : input;
    }
    // cells[k] is the input index of the sorted seed seed_at(k). blocks_ holds the beginnings of tasks.
    template <class SeedAt>
    void clip_blocks(std::span<const std::int32_t> cells, SeedAt seed_at, bool fallback, ResultBuilder& out,
                     const Share& share);
    // The same for the sorted seeds order_.
    void clip_order(std::span<const std::int32_t> cells, bool fallback, ResultBuilder& out, const Share& share);
    Cell& clip_by_faces(std::size_t seed, Worker& worker) const;
    Cell& clip_by_faces(std::size_t seed, const KeptCell& cell, Worker& worker) const;
    // In moving_seeds.cpp: writes the kept cells, after all pending rows.
    void write_kept(KeptCells& kept, ResultBuilder& out, const Share& share);
    Cell& build_from_candidates(std::size_t seed, Worker& worker) const;
    void search(std::size_t seed, Worker& worker) const;
    // Returns whether the cell is empty for a plain reason, and writes it then.
    bool hide(std::size_t seed, Worker& worker) const;
    // Writes the cell, or stores that its search was given up.
    void finish(Cell* cell, std::size_t seed, Worker& worker) const;
    // hard_cells.cpp: cells that the workers gave up.
    void clip_hard(ResultBuilder& out);
    // Adds farther images to the seeds if searches for them would cost more. Returns whether it did.
    [[nodiscard]] bool widen_images();
    // Makes hard cells as others, among wider images.
    void clip_hard_again(ResultBuilder& out, const Share& share);
    [[nodiscard]] std::vector<std::int32_t> collect_hard();
    bool triangulate();
    template <class Build>
    void clip_each(const std::vector<std::int32_t>& seeds, ResultBuilder& out, const Build& build);

    std::optional<ThreadPool> pool_;
    Job job_;
    Progress progress_;
    bool sorted_ = false, searchable_ = false;
    bool lacks_images_ = false;  // until they are searched
    // Their memory is kept for the next job.
    SeedSorter sorter_;
    SortedSeeds seeds_;
    SeedImages images_;
    std::vector<std::int32_t> buried_;  // input indices of seeds lighter than another at the same place
    Hierarchy hierarchy_;
    // Scratch memory, kept from job to job.
    Buffer<std::int32_t> position_;  // input index -> sorted seed, -1 for duplicates; built when some are clipped
    bool positions_known_ = false;
    Buffer<std::int32_t> row_places_;  // by sorted seed, if the job has a row_order
    std::vector<std::int32_t> order_;  // sorted seeds to clip
    std::vector<std::size_t> blocks_;  // beginnings of blocks, and the end of the last
    std::vector<bool> chosen_;
    std::span<double> powers_;  // of clip_first(), else empty
    KeptCells* kept_ = nullptr;
    const Kernels* kernels_ = nullptr;  // for which the workers are made
    std::vector<std::unique_ptr<Worker>> workers_;
    std::optional<Delaunay> delaunay_;    // of all seeds, made when hard cells are worth it
    std::optional<Unwrapped> unwrapped_;  // of those of delaunay_, if they have been
};

}  // namespace votess::cpu
