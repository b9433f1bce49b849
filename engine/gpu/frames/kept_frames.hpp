// Cells that a recorded frame keeps for the next one. README.md shows why kept cells are right.
#pragma once

#include <cstdint>

#include "gpu/cells/device_cells.hpp"
#include "gpu/seeds/device_seeds.hpp"

namespace votess::gpu {

class KeptFrames {
public:
    // Returns the bytes of the stored cells of so many seeds.
    [[nodiscard]] static VkDeviceSize bytes(std::uint32_t seeds, bool images);
    // Reserves arrays for up to `points` seeds and images. store: of bytes(seeds).
    void reserve(Workspace& workspace, std::uint32_t points, std::uint32_t seeds, const Slice& store);
    // Sets the cells of a frame of `count` seeds. DeviceCells::set_job() comes before.
    void set_job(const DeviceSeeds& seeds, const DeviceCells& cells, std::uint32_t count);

    // Records the test of the stored cells. Cells that do not hold are pending; if many are, all are. fresh: all are.
    void record_recall(Recorder& recorder, const Passes& passes, bool fresh) const;
    // Records after all pending cells were tried: kept ones that do not match these are pending.
    void record_match(Recorder& recorder, const Passes& passes) const;
    // Records that all cells are pending unless the kept ones are right.
    void record_judgment(Recorder& recorder, const Passes& passes) const;
    void record_store(Recorder& recorder, const Passes& passes) const;

private:
    void record_reset(Recorder& recorder) const;
    // Records that all cells are pending if the judgment failed, or more cells than this are.
    void record_drop(Recorder& recorder, const Passes& passes, std::uint32_t max_pending) const;

    std::uint32_t seeds_ = 0, max_images_ = 0;
    Slice places_, store_, state_;
    Bindings bindings_;
    KeptPush push_{};
    ClipPush clip_{};
    CoverPush cover_{};
};

}  // namespace votess::gpu
