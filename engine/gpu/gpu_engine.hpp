// The GPU engine. A part is the seeds that the device holds at once; a chunk is the cells in flight.
// Two chunks alternate: the device clips one while the CPU finishes the cells that the other left.
// The first 2,048 cells of a part are a trial, which chooses the passes for the next ones (schedule.hpp).
// Rows stay on the device until their buffer is full or the part is done; they come down in the order of its seeds.
// Cells that the device cannot prove are pending until the exact clipper makes them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/stage_clock.hpp"
#include "gpu/cells/part_download.hpp"
#include "gpu/cells/pending_cells.hpp"
#include "gpu/chunk.hpp"
#include "gpu/domain/parts.hpp"
#include "gpu/passes/passes.hpp"
#include "gpu/seeds/seed_store.hpp"
#include "output/exact_clipper.hpp"
#include "output/result_builder.hpp"

namespace votess::gpu {

// Limits that tests vary. 0 = as the device allows.
struct EngineLimits {
    std::uint32_t max_seeds = 0;    // on the device at once
    std::uint32_t max_entries = 0;  // of rows, on the device at once
    std::uint32_t local_size = 0;
    std::uint32_t max_walk_visits = 0;
    double chunk_seconds = 0;     // the device may take for a chunk; sets the cells of the next one
    double volume_tolerance = 0;  // relative error that the device may prove; 0: by the precision of the job
};

class GpuEngine {
public:
    GpuEngine(std::shared_ptr<vulkan::Device> device, ExactClipper& clipper, const EngineLimits& limits = {});

    // Goes through the stages upload, sort, knn, clip, fallback, download, and enters each on the clock. Fills the
    // result except its seconds. After an error the next run starts afresh. domain: the job's; null when no device
    // clips it.
    void run(const Job& job, const DeviceDomain* domain, StageClock& clock, detail::Result& result);

    [[nodiscard]] vulkan::Device& device() { return *device_; }
    [[nodiscard]] vulkan::Memory& memory() { return memory_; }

private:
    [[nodiscard]] PassSettings pass_settings() const;
    [[nodiscard]] std::uint32_t chunk_cells(const PassSettings& settings) const;
    void begin(const Job& job);
    // Finds the seeds and images. Returns whether the passes can do the job; else the exact clipper takes all cells.
    [[nodiscard]] bool find_seeds(const DeviceDomain& domain);
    void find_parts();
    // Returns the most seeds for which all buffers stay within the device's limits.
    [[nodiscard]] std::uint32_t max_seeds() const;
    void upload_part(std::size_t index);
    void sort_part();
    void clip_part(std::size_t index);
    // Adds the cells that a finished chunk left to the pending ones.
    void collect(const Chunk& chunk, Schedule& schedule);
    // Downloads the cells that are on the device. all_cells: all others are the CPU's.
    void take_batch(bool all_cells);
    // Makes pages of the result present while the device works: those of this share of the cells, and of their rows if
    // take_batch() will place these.
    void touch_results(double share, bool first_batch);
    // Returns the number of cells left to the CPU that may have ties of small whole numbers.
    [[nodiscard]] std::size_t uncertain_cells(const Chunk& chunk) const;
    // Returns how many cells the next chunk should have, by the time that this one took: at most host_seconds on the
    // host's clock.
    [[nodiscard]] std::uint32_t paced_cells(const Chunk& chunk, double host_seconds, std::uint32_t most) const;
    void leave_to_cpu(std::uint32_t first, std::uint32_t count);
    void clip_pending(double progress);
    [[nodiscard]] std::int32_t input_of(std::uint32_t member) const {
        return part_.members.empty() ? static_cast<std::int32_t>(member) : part_.members[member];
    }
    // Returns whether the part's own members are all seeds, in their order.
    [[nodiscard]] bool is_in_input_order() const {
        return parts_->size() == 1 && part_.own_count == job_.points.count();
    }
    // Returns the first member with a name. Members before it have their input index and no shift.
    [[nodiscard]] std::uint32_t named_from() const {
        return is_in_input_order() && (!periodic_ || periodic_->moves.empty()) ? part_.own_count : 0;
    }
    [[nodiscard]] double progress_now() const { return clipping.at(done_cells_, job_.points.count()); }
    void finish(detail::Result& result);
    std::shared_ptr<vulkan::Device> device_;
    vulkan::Memory memory_;
    ExactClipper& clipper_;
    EngineLimits limits_;
    std::optional<Passes> passes_;
    SeedStore seeds_;
    PartDownload download_;
    std::optional<Chunk> chunks_[2];

    Job job_;
    Progress progress_;
    ResultBuilder result_;
    std::optional<Parts> parts_;
    std::optional<PeriodicPart> periodic_;
    Part part_;
    Box box_;                   // of all parts
    bool device_clips_ = true;  // else the exact clipper takes all cells
    bool duplicates_ = false;   // there may be some
    PendingCells pending_;
    bool lists_only_ = false;  // the device makes lists, and the CPU's clipper makes the cells from them
    std::size_t done_cells_ = 0;
    StageClock* clock_ = nullptr;  // of the run
    Chunk::Seconds device_seconds_;
};

}  // namespace votess::gpu
