// The seeds of a stream: looked at once, then dealt out to blocks.
#pragma once

#include <optional>
#include <vector>

#include "core/thread_pool.hpp"
#include "distributed/blocks/partition.hpp"
#include "distributed/stream/spool.hpp"
#include "distributed/stream/stages.hpp"
#include "input/job.hpp"
#include "votess/stream.hpp"

namespace votess::stream {

class Intake {
public:
    // waiting: where seeds go that can be had only once.
    Intake(StreamSource& source, const Options& options, const std::string& folder, std::uint64_t memory,
           Stages& stages);

    // The first reading. Checks the points as far as no box has to be settled.
    void look();
    [[nodiscard]] std::uint64_t seeds() const { return seeds_; }
    [[nodiscard]] bool weighted() const { return weighted_; }
    [[nodiscard]] const Box& bounds() const { return bounds_; }
    [[nodiscard]] std::uint64_t bytes() const { return file_ ? file_->size() : 0; }

    struct Dealt {
        std::vector<Spool> ids, points, weights;  // by block; int64, 3 doubles and 1 a seed
        std::vector<Box> boxes;                   // around the places of its seeds, times the scale
        std::vector<double> heaviest;             // times the scale squared
        std::vector<std::uint64_t> counts;
        std::vector<double> inside;  // one seed that is not left out, if there is any
    };
    // The second one, by options with a box.
    [[nodiscard]] Dealt deal(const Options& settled, std::size_t blocks, TemporaryFile& ids, TemporaryFile& seeds);

private:
    // Calls task(first, some) with not too many seeds at once.
    template <class Task>
    void read(const Task& task);
    // Throws unless the piece has weights, radii or neither as the pieces before it had.
    void check_kind(std::uint64_t first, const StreamSeeds& some);
    void check(std::uint64_t first, const StreamSeeds& some);
    void take_sample(std::uint64_t first, std::span<const double> points);
    [[nodiscard]] blocks::Partition partition(const Options& settled, std::size_t blocks);

    StreamSource& source_;
    const Options& options_;
    Stages& stages_;
    ThreadPool pool_;
    std::optional<TemporaryFile> file_;
    std::optional<Spool> waiting_, waiting_weights_;
    std::size_t max_at_once_, max_sampled_;
    std::uint64_t seeds_ = 0, every_ = 1;
    bool weighted_ = false, radii_ = false, looked_ = false;
    Box bounds_;
    std::vector<double> sample_;
};

}  // namespace votess::stream
