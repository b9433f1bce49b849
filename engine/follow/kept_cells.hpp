// Moving seeds. The cells of the last call are tested at the new places. Those that still hold are kept, and the others
// are made again.
//
// A stored cell has planes and corners, but no places. After a call all stored cells match: a corner of four seeds or
// walls is in the cells of all of them. At new places each sign is tested once, by the cell of the lowest seed around
// it. A corner must have the right orientation, and an edge the right direction. Where a sign is wrong, flips
// (follow/flip.hpp) change the cells around it, and these are tested again. A sign that stays wrong or uncertain leaves
// all cells around it pending. The walk makes pending cells among all seeds, so they are right. Where such a cell has
// gained or lost a corner, the other cells around the corner become pending too, until all match again.
//
// Why kept cells are right. Each is a closed surface, as it was made or flipped, and a convex polytope, because its
// signs are right. It shares whole faces with its
// neighbors, kept or made, because corners match. So nearly all places of the domain have the same number of cells, and
// covers_once() finds that it is 1. Let power_i(x) = |x - p_i|^2 - w_i, and let k be the cell at x. Along a line off
// all edges, power_k(x) - |x|^2 is linear in each cell. Its slope falls at each face, because the neighbor lies beyond
// the face. Such a function lies below the line of its last piece. So power_k(x) <= power_m(x) for each seed m that has
// a cell: the cells are the diagram of these seeds.
// A seed without a cell is pending, unless four others certainly hide it (follow/hiding_seeds.hpp).
//
// Where a seed and all its neighbors stay where they were, the signs of a kept cell stay right without a test.
//
// Between equal seeds slopes would not fall, so no two kept cells have equal seeds. A cell with a tie is always
// pending, and leaves its neighbors pending: only a search finds the other seeds of a tie.
//
// Where seeds come or go, also across a wall that drops them, those of the last call are found by their places
// (follow/match_seeds.hpp). A new seed has no cell, and the cells next to one that has left count as tied. So both are
// pending.
//
// Corners need no test against the walls of other cells. A cell lies inside of its own walls. So the number of cells
// over a place, 1 in the domain, does not grow where a line from there crosses a wall outward, and is 0 or 1 beyond. In
// the plane of a wall the same is true of the faces there: they share whole edges, which end at other walls. So if a
// wall has a face anywhere, it has one at each place where it bounds the domain, and no cell is beyond. meets_walls()
// finds a face of each wall that bounds the domain. The walls of a box alone bound no other region, and need no face.
// Walls that change may touch cells without a face, in a tie that no cell knows. Then no cell is kept.
//
// Images are told apart because all corners are nearer to their seeds than half of the least width of a period. So at
// most one image of a cell is over a place: the one whose way to it is less than half of each short vector, in
// multiples of these.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/buffer.hpp"
#include "core/thread_pool.hpp"
#include "follow/flip.hpp"
#include "follow/kept_cell.hpp"
#include "follow/kept_rows.hpp"
#include "follow/loose_cell.hpp"
#include "follow/sign_test.hpp"
#include "index/sorted_seeds.hpp"
#include "input/job.hpp"
#include "polytope/cell_shape.hpp"

namespace votess::cpu {

class KeptCells {
public:
    // Whether cells of such a job can be kept.
    [[nodiscard]] static bool follows(const Job& job);
    void clear();

    enum class Plan {
        repair,  // order() holds: test the cells and make the pending ones
        record,  // make all cells and store them
        sample,  // make all cells; afterwards store those of in_sample(), for the plan of the next call
        none,    // make all cells
    };
    // Looks at a sample of the cells at the new places. Matches seeds where some have come or gone.
    [[nodiscard]] Plan plan(const Job& job, std::string_view instructions);
    // Sorted seeds of the last call: indices in the input.
    [[nodiscard]] std::span<const std::int32_t> order() const { return order_; }

    // Begins to store cells. workers: of store().
    void begin(Plan plan, const Job& job, const SortedSeeds& seeds, ThreadPool& pool);
    // Consecutive seeds of a sample are whole blocks.
    [[nodiscard]] bool in_sample(std::size_t seed) const { return seed / sample_block % sample_step_ == 0; }
    static constexpr std::size_t sample_block = 16;
    // Stores a cell, from any thread; one at a time for each worker. ids: by face, sorted seeds or walls. shifts: of
    // images, by face, or none. ranks: by face. tied: some sign of the cell was 0.
    void store(unsigned worker, std::size_t seed, std::span<const std::int32_t> ids,
               std::span<const exact::Shift> shifts, std::span<const std::uint32_t> ranks, const CellShape& shape,
               bool tied);
    // Notes a cell that is too large to be stored.
    void store_large(std::size_t seed, std::span<const std::int32_t> ids);
    void store_none(std::size_t seed);
    // Call when all cells are stored.
    void commit();

    // Tests all cells and flips; after begin(Plan::repair).
    void test(ThreadPool& pool);
    // Takes the pending cells, ascending. None: all match.
    void take_pending(std::vector<std::int32_t>& out);
    // Whether it pays to make so many.
    [[nodiscard]] bool pays(std::size_t pending) const;
    enum class Among { all_seeds, hidden_seeds };
    // Whether two seeds are at the same place.
    [[nodiscard]] bool any_equal(Among among) const;
    [[nodiscard]] bool covers_once();
    [[nodiscard]] bool is_kept(std::size_t seed) const { return state_[seed].load(std::memory_order_relaxed) == kept; }
    // Whether a seed is kept without a cell.
    [[nodiscard]] bool is_hidden(std::size_t seed) const { return is_kept(seed) && cells_[seed] == nullptr; }
    // Whether a kept cell has the faces that it had in the last call.
    [[nodiscard]] bool has_same_faces(std::size_t seed) const { return (found_[seed] & new_faces) == 0; }
    [[nodiscard]] KeptRows& rows() { return rows_; }
    [[nodiscard]] std::size_t faces(std::size_t seed) const { return faces_[seed]; }  // of a stored cell
    [[nodiscard]] const SeedPlace* places() const { return places_.data(); }          // by sorted seed
    // Lets a kept cell be made again.
    void drop(std::size_t seed) { state_[seed].store(made, std::memory_order_relaxed); }
    [[nodiscard]] KeptCell cell(std::size_t seed) const { return KeptCell(cells_[seed]); }
    void prefetch(std::size_t seed) const {
        constexpr std::size_t usual_bytes = 192;
        for (std::size_t k = 0; k < usual_bytes && cells_[seed] != nullptr; k += 64)
            __builtin_prefetch(cells_[seed] + k);
    }
    // The places of neighbors that tests need, or of all. Call a few cells after prefetch().
    void prefetch_places(std::size_t seed, bool of_all) const {
        if (cells_[seed] == nullptr) return;
        const auto ids = cell(seed).ids();
        const auto fetch = [&](std::int32_t id) {
            __builtin_prefetch(&places_[static_cast<std::size_t>(std::max(id, 0))]);
        };
        if (of_all)
            std::ranges::for_each(ids, fetch);
        else
            for (const std::uint8_t f : cell(seed).planes()) fetch(ids[f]);
    }

private:
    enum State : std::uint8_t { kept, pending, made };
    using Flags = std::unique_ptr<std::atomic<std::uint8_t>[]>;
    struct Worker {  // of one thread
        std::vector<std::unique_ptr<std::byte[]>> chunks;
        std::size_t chunk = 0, used = 0;  // of chunks
        CornerEdges edges;
        LooseCell loose;
        SignTest signs;
        Flip flip;
        std::vector<std::pair<std::size_t, SeedPlace>> crossed;  // seeds across an edge of the box, and where they were
        std::vector<std::size_t> wrong;                          // changed and not tested yet
        std::vector<std::size_t> later;                          // wrong, and flips would change cells of other workers
        std::vector<std::size_t> unmended;                       // wrong, without a flip
        std::vector<std::size_t> over_point;                     // right, and over the frame's point
        std::size_t grown = 0;                                   // cells that got new memory
    };

    // Bounds of a seed's power at the frame's point. They are infinite where another image may be nearer.
    struct Powers {
        float least, most;
    };
    struct Range {  // of seeds
        std::size_t begin, end;
    };

    void set_frame(const Job& job);
    void set_walls(const Domain& domain, double largest);  // largest: coordinate
    // Whether each wall that bounds the domain has a face.
    [[nodiscard]] bool meets_walls();
    [[nodiscard]] SeedPlace place_of(const Job& job, std::size_t row) const;
    [[nodiscard]] bool rows_change(const Job& job) const;
    [[nodiscard]] bool match(const Job& job, bool same_rows);
    // factor: of the usual limits.
    [[nodiscard]] bool sample_pays(const Job& job, double factor = 1);
    [[nodiscard]] bool is_still(std::size_t seed) const {
        if (still_[seed] != (was_kept | has_stayed)) return false;
        if (all_stay_) return true;
        for (const std::int32_t id : cell(seed).ids())
            if (id >= 0 && (still_[static_cast<std::size_t>(id)] & has_stayed) == 0) return false;
        return true;
    }
    void mark(std::int32_t id) {
        if (id < 0) return;
        std::uint8_t expected = kept;
        state_[static_cast<std::size_t>(id)].compare_exchange_strong(expected, pending, std::memory_order_relaxed);
    }
    // Whether four seeds certainly hide this one: those of the last call, or others.
    [[nodiscard]] bool hides(std::size_t seed, Worker& worker);
    [[nodiscard]] bool is_right(std::size_t seed, Worker& worker);
    // Makes shifts count from the new place of a seed that has crossed an edge of a periodic box.
    void cross(std::size_t seed, const SeedPlace& before, const Domain& domain, Worker& worker);
    // Stores the worker's loose cell.
    void put(std::size_t seed, Worker& worker);
    bool find_flip_of(std::size_t seed, Range range, Worker& worker);
    void flip(const Flip& flip, Worker& worker);
    void mend(std::size_t seed, Range range, Worker& worker);
    // Whether the cell may be over the frame's point.
    [[nodiscard]] bool may_hold(std::size_t seed) const;
    [[nodiscard]] bool is_no_farther(std::size_t seed) const;
    [[nodiscard]] Powers powers_of(const SeedPlace& seed) const;
    void mark_around(const KeptCell& cell, const KeptCell::Corner& corner);
    void mark_wrong(const KeptCell& cell, std::size_t seed, const SignTest& signs);
    void mark_changes(const KeptCell& before, const KeptCell& now, Worker& worker);
    [[nodiscard]] static std::size_t room_of(const std::byte* record);
    [[nodiscard]] std::byte* allocate(std::size_t bytes, Worker& worker);
    [[nodiscard]] std::array<double, 3> way_to_point(const SeedPlace& from) const {
        return nearest_way(frame_, from.x, frame_.point);
    }

    bool complete_ = false, sampled_ = false;  // cells_ has all cells, or those of the sample
    std::size_t count_ = 0, made_ = 0;         // made_: since the sort
    std::size_t points_ = 0;                   // of the last call, with those outside
    std::array<bool, 3> periodic_{};
    std::vector<double> given_;  // see numbers_of()
    std::vector<SignWall> walls_;
    std::vector<std::int32_t> facets_;      // Domain::facets
    std::vector<std::size_t> facet_seeds_;  // of each: a seed whose cell had a face there
    std::size_t sample_step_ = 1;
    unsigned unmatched_ = 0;  // calls with other numbers of seeds than those of the sample
    // Samples in a row of which by far too many cells were wrong, and calls until the next one is stored.
    unsigned refusals_ = 0, skipped_ = 0;
    Plan plan_ = Plan::record;
    Buffer<std::int32_t> order_;
    std::vector<std::byte*> cells_;    // by sorted seed
    std::vector<std::uint8_t> faces_;  // of each; 0 of a seed without a cell, the most of one that is too large
    std::vector<std::byte*> hiding_;   // with weights, of each without a cell: seeds that hide it, or null
    std::deque<Worker> workers_;
    Flags state_, always_;  // by sorted seed. always_: next to a cell that is not stored
    Buffer<SeedPlace> places_{Buffer<SeedPlace>::Pages::huge};  // accessed at random
    Buffer<Powers> powers_{Buffer<Powers>::Pages::huge};        // by sorted seed
    // Whether the last call was a repair, so that its cells had right signs in its frame.
    bool settled_ = false;
    SignFrame settled_frame_{};
    static constexpr std::uint8_t was_kept = 1, has_stayed = 2;
    std::vector<std::uint8_t> still_;  // by sorted seed: whether its cell was kept, and whether it has not moved since
    static constexpr std::uint8_t new_faces = 1, right = 2;
    // By sorted seed: whether a flip may have changed the faces of its cell, and whether its signs are right as it is.
    std::vector<std::uint8_t> found_;
    bool all_stay_ = false;
    std::vector<std::size_t> over_;  // kept cells that may be over the frame's point: one or none
    SignFrame frame_{};
    SignTester test_ = nullptr;
    KeptRows rows_;  // of the last call, where all its cells are stored
};

}  // namespace votess::cpu
