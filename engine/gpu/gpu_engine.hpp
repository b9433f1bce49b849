// The Vulkan engine: compute passes. What it cannot certify the exact clipper of the CPU takes,
// chunk by chunk, while the device works on the next chunk.
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

// What tests vary beyond the options. 0 = as the device allows.
struct EngineLimits {
    std::uint32_t max_seeds = 0;    // on the device at once
    std::uint32_t max_entries = 0;  // of rows, on the device at once
    std::uint32_t local_size = 0;
    std::uint32_t max_walk_visits = 0;
    double chunk_seconds = 0;  // that the device may take for a chunk; the next one has as many cells
};

class GpuEngine {
public:
    GpuEngine(std::shared_ptr<vulkan::Device> device, ExactClipper& clipper, const EngineLimits& limits = {});

    // Goes through the stages upload, sort, knn, clip, fallback, download, and enters each on the clock. Fills the
    // result except its seconds. After an error the next run starts afresh. domain: that of the job; null when no
    // device clips it.
    void run(const Job& job, const DeviceDomain* domain, StageClock& clock, detail::Result& result);

    [[nodiscard]] vulkan::Device& device() { return *device_; }
    [[nodiscard]] vulkan::Memory& memory() { return memory_; }

private:
    [[nodiscard]] PassSettings pass_settings(const Options& options) const;
    [[nodiscard]] std::uint32_t chunk_cells(const PassSettings& settings) const;
    void begin(const Job& job);
    // Returns whether the passes can do the job; else the exact clipper takes all cells.
    [[nodiscard]] bool find_seeds(const DeviceDomain& domain);
    void find_parts();
    // Seeds for which all buffers stay within the device's limits.
    [[nodiscard]] std::uint32_t max_seeds() const;
    void upload_part(std::size_t index);
    void sort_part();
    void clip_part(std::size_t index);
    // Adds the cells that a finished chunk leaves to the pending ones.
    void collect(const Chunk& chunk, Schedule& schedule);
    // Takes over the cells that are on the device. all_cells: no others come, but for the CPU's.
    void take_batch(bool all_cells);
    // Cells left to the CPU that may have ties of small whole numbers.
    [[nodiscard]] std::size_t uncertain_cells(const Chunk& chunk) const;
    // How many cells the next chunk should have, by the time that this one took; on the host's clock, it took at most
    // host_seconds.
    [[nodiscard]] std::uint32_t paced_cells(const Chunk& chunk, double host_seconds, std::uint32_t most) const;
    void leave_to_cpu(std::uint32_t first, std::uint32_t count);
    void clip_pending(double progress);
    [[nodiscard]] std::int32_t input_of(std::uint32_t member) const {
        return part_.members.empty() ? static_cast<std::int32_t>(member) : part_.members[member];
    }
    // Whether the part's own members are all seeds, in their order.
    [[nodiscard]] bool is_in_input_order() const {
        return parts_->size() == 1 && part_.own_count == job_.points.count();
    }
    // Members from here on have names; those before are called as in the input, and not shifted.
    [[nodiscard]] std::uint32_t named_from() const {
        return is_in_input_order() && (!periodic_ || periodic_->moves.empty()) ? part_.own_count : 0;
    }
    [[nodiscard]] double progress_now() const { return clipping.at(done_cells_, job_.points.count()); }
    void finish(detail::Result& result);
    void check_messages();

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
    bool duplicates_ = false;   // there are some, or there may be
    PendingCells pending_;
    bool lists_only_ = false;  // the device gives lists, and the CPU's clipper makes the cells from them
    std::size_t done_cells_ = 0;
    StageClock* clock_ = nullptr;  // of the run
    Chunk::Seconds device_seconds_;
};

}  // namespace votess::gpu
