// Reads the seeds of a stream twice: for bounds, number and a sample, then into the files of their blocks.
#pragma once

#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "distributed/blocks/partition.hpp"
#include "distributed/stream/spool.hpp"
#include "distributed/stream/stages.hpp"
#include "input/hull_of_parts.hpp"
#include "input/job.hpp"
#include "votess/stream.hpp"

namespace votess::stream {

class Intake {
public:
    // Seeds that come only once are copied into a temporary file in the folder.
    // hull: the domain is that of the points.
    Intake(StreamSource& source, const Settled& whole, bool hull, const std::string& folder, DiskUse& use,
           std::uint64_t memory, Stages& stages);

    // The first reading. Checks the points as far as that needs no box.
    void scan();
    [[nodiscard]] std::uint64_t seeds() const { return seeds_; }
    [[nodiscard]] bool weighted() const { return weighted_; }
    // Whether float32 holds all coordinates.
    [[nodiscard]] bool singles() const { return singles_; }
    [[nodiscard]] const Box& bounds() const { return bounds_; }
    // Returns the walls of the hull. Throws when it has no interior.
    [[nodiscard]] std::vector<Wall> hull_walls() { return hull_->walls(seeds_); }

    struct BlockSpools {
        std::vector<Spool> ids, points, weights;  // by block: an int64, three float64 and one for each seed
        std::vector<Box> boxes;                   // around the places of its seeds, times the scale
        std::vector<double> heaviest;             // times the scale squared
        std::vector<std::uint64_t> counts;
        std::vector<double> inside;  // one seed that is not dropped, or empty
    };
    // The second reading. of_blocks: the run of the blocks.
    [[nodiscard]] BlockSpools distribute(const Settled& of_blocks, std::size_t blocks, TemporaryFile& ids,
                                         TemporaryFile& seeds);

private:
    // Calls task(first, seeds) piece by piece, with at most max_at_once_ seeds in space.
    template <class Task>
    void read(const Task& task);
    // Throws unless the piece has weights, radii or neither, like the pieces before it.
    void check_kind(std::uint64_t first, const StreamSeeds& some);
    void check(std::uint64_t first, const StreamSeeds& some);
    void take_sample(std::uint64_t first, std::span<const double> points);
    [[nodiscard]] blocks::Partition partition(Settled of_blocks, std::size_t blocks);

    StreamSource& source_;
    Region region_;  // in space
    bool planar_;
    Stages& stages_;
    ThreadPool pool_;
    std::optional<TemporaryFile> file_;
    std::optional<Spool> copied_points_, copied_weights_;
    std::size_t max_at_once_, max_sampled_;
    std::uint64_t seeds_ = 0, every_ = 1;
    bool weighted_ = false, radii_ = false, scanned_ = false, singles_ = true;
    Box bounds_;
    std::optional<HullOfParts> hull_;
    std::vector<double> sample_;
};

}  // namespace votess::stream
