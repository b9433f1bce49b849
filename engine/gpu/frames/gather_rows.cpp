#include "gpu/frames/gather_rows.hpp"

#include <algorithm>
#include <limits>

#include "gpu/frames/frame.hpp"

namespace votess::gpu {
namespace {

using votess::vulkan::Resolved;

constexpr std::size_t cells_of_task = 4096;

// Puts the cells of a frame into the order of the points.
class Gatherer {
public:
    Gatherer(const FrameArrays& frame, const Resolved& more, const Want& want, bool narrow, ThreadPool& pool)
        : frame_(frame), more_(more) {
        const std::size_t count = frame.cells.size();
        out_.kept = frame.kept;
        out_.status.resize_uninitialized(count);
        if (want.volumes) out_.volumes.resize_uninitialized(count);
        if (want.centroids && narrow) out_.centroids32.resize_uninitialized(3 * count);
        if (want.centroids && !narrow) out_.centroids64.resize_uninitialized(3 * count);
        if (want.neighbors) out_.indptr.resize_uninitialized(count + 1);
        const std::size_t entries = place_rows();
        if (want.neighbors) out_.indices.resize_uninitialized(entries);
        if (!frame.areas.empty()) out_.face_areas.resize_uninitialized(entries);
        if (!frame.shifts.empty()) out_.shifts.resize_uninitialized(3 * entries);
        pool.run((count + cells_of_task - 1) / cells_of_task, [&](std::size_t task, unsigned) {
            each_cell(task * cells_of_task, std::min(count, (task + 1) * cells_of_task),
                      [&](std::size_t i, std::size_t r) { copy(i, r); });
        });
    }
    [[nodiscard]] detail::FrameRows take() { return std::move(out_); }

private:
    static constexpr std::size_t by_device = std::numeric_limits<std::size_t>::max();

    // Calls use(cell, number of the resolved cell or by_device).
    void each_cell(std::size_t begin, std::size_t end, const auto& use) const {
        auto next = std::ranges::lower_bound(more_.cells, begin);
        for (std::size_t i = begin; i < end; ++i) {
            const bool resolved = next != more_.cells.end() && *next == i;
            use(i, resolved ? static_cast<std::size_t>(next - more_.cells.begin()) : by_device);
            if (resolved) ++next;
        }
    }

    // Sets status and offsets. Returns the number of entries.
    std::size_t place_rows() {
        std::uint64_t entries = 0;
        each_cell(0, frame_.cells.size(), [&](std::size_t i, std::size_t r) {
            const std::uint32_t status =
                r == by_device ? frame_.cells[i].status : static_cast<std::uint32_t>(more_.status[r]);
            out_.status[i] = static_cast<std::int32_t>(status);
            if (votess::vulkan::detail::is_unresolved(status)) ++out_.unresolved;
            if (out_.indptr.empty()) return;
            out_.indptr[i] = static_cast<std::int32_t>(entries);
            entries += r == by_device ? frame_.cells[i].row_length
                                      : static_cast<std::uint64_t>(more_.indptr[r + 1] - more_.indptr[r]);
            if (entries > std::numeric_limits<std::int32_t>::max())
                throw Error(ErrorCode::unsupported,
                            "the rows of the frame have more than 2147483647 entries, which "
                            "int32 offsets cannot count: give fewer points");
        });
        if (!out_.indptr.empty()) out_.indptr[frame_.cells.size()] = static_cast<std::int32_t>(entries);
        return entries;
    }

    void copy(std::size_t i, std::size_t r) {
        if (!out_.indptr.empty()) copy_row(i, r);
        const bool has_cell = out_.status[i] == static_cast<std::int32_t>(CellStatus::certified);
        if (!out_.volumes.empty()) {
            const float volume = r == by_device ? frame_.geometry[4 * i + 3] : static_cast<float>(more_.volumes[r]);
            out_.volumes[i] = has_cell ? volume : 0;
        }
        if (!out_.centroids32.empty()) copy_centroid(i, r, has_cell, out_.centroids32);
        if (!out_.centroids64.empty()) copy_centroid(i, r, has_cell, out_.centroids64);
    }

    template <class Real>
    void copy_centroid(std::size_t i, std::size_t r, bool has_cell, Buffer<Real>& out) const {
        for (std::size_t k = 0; k < 3; ++k) {
            double x = std::numeric_limits<double>::quiet_NaN();
            if (has_cell)
                x = r == by_device ? frame_.seeds[3 * i + k] + static_cast<double>(frame_.geometry[4 * i + k])
                                   : more_.centroids[3 * r + k];
            out[3 * i + k] = static_cast<Real>(x);
        }
    }

    void copy_row(std::size_t i, std::size_t r) {
        const auto to = static_cast<std::size_t>(out_.indptr[i]);
        const std::size_t length = static_cast<std::size_t>(out_.indptr[i + 1]) - to;
        const bool resolved = r != by_device;
        const std::size_t from = resolved ? static_cast<std::size_t>(more_.indptr[r]) : frame_.cells[i].row_begin;
        std::copy_n((resolved ? more_.indices.data() : frame_.indices.data()) + from, length, out_.indices.data() + to);
        for (std::size_t e = 0; e < length && !out_.face_areas.empty(); ++e)
            out_.face_areas[to + e] = resolved ? static_cast<float>(more_.areas[from + e]) : frame_.areas[from + e];
        for (std::size_t e = 0; e < length && !out_.shifts.empty(); ++e)
            std::copy_n(resolved ? &more_.shifts[3 * (from + e)] : &frame_.shifts[4 * (from + e)], 3,
                        &out_.shifts[3 * (to + e)]);
    }

    const FrameArrays& frame_;
    const Resolved& more_;
    detail::FrameRows out_;
};

}  // namespace

detail::FrameRows gather_rows(const FrameArrays& frame, const Resolved& more, const Want& want, bool narrow,
                              ThreadPool& pool) {
    return Gatherer(frame, more, want, narrow, pool).take();
}

std::vector<std::int8_t> padded_shifts(const detail::FrameRows& rows) {
    std::vector<std::int8_t> padded(rows.shifts.size() / 3 * 4);
    for (std::size_t e = 0; e < padded.size() / 4; ++e) std::copy_n(&rows.shifts[3 * e], 3, &padded[4 * e]);
    return padded;
}

}  // namespace votess::gpu
