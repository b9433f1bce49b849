// Frames of points in the host's memory. bindings/python/tests/test_gpu.py has more.
#include <doctest/doctest.h>

#include <span>

#include "core/progress.hpp"
#include "gpu/frames/host_frames.hpp"
#include "support/generators.hpp"
#include "support/gpu/frame.hpp"

using namespace test::frame;
using votess::ErrorCode;
using votess::gpu::HostFrames;

namespace {

constexpr votess::Want everything{.neighbors = true, .volumes = true, .centroids = true, .areas = true};

Rows rows_of(const votess::detail::FrameRows& from) {
    Rows rows;
    for (std::size_t i = 0; i < from.status.size(); ++i) {
        const auto begin = static_cast<std::size_t>(from.indptr[i]), end = static_cast<std::size_t>(from.indptr[i + 1]);
        rows.rows.emplace_back(from.indices.data() + begin, from.indices.data() + end);
        rows.areas.emplace_back(from.face_areas.data() + begin, from.face_areas.data() + end);
        rows.shifts.emplace_back();
        if (!from.shifts.empty()) rows.shifts[i].assign(from.shifts.data() + 3 * begin, from.shifts.data() + 3 * end);
        rows.status.push_back(static_cast<CellStatus>(from.status[i]));
    }
    rows.volumes.assign(from.volumes.begin(), from.volumes.end());
    rows.centroids.assign(from.centroids64.begin(), from.centroids64.end());
    return rows;
}

VKAPI_ATTR VkResult VKAPI_CALL never_done(VkDevice, std::uint32_t, const VkFence*, VkBool32, std::uint64_t) {
    return VK_TIMEOUT;
}
VKAPI_ATTR VkResult VKAPI_CALL lost(VkQueue, std::uint32_t, const VkSubmitInfo*, VkFence) {
    return VK_ERROR_DEVICE_LOST;
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu frame: points of the host, rows that do not fit, cancelled and failed runs") {
        test::Gpu gpu;
        const test::PointSet set = test::with_duplicates(200, 5, 21);
        PlanOptions options = options_for(set);
        const auto expected = on_cpu(set, options);
        const auto run = [&](HostFrames& frames) { return frames.run(std::span<const double>(set.points), {}); };
        options.max_entries = 1500;  // half of the rows
        HostFrames frames(gpu.device, options, everything, 1);
        CHECK(!frames.has_run());
        const auto first = run(frames);
        CHECK(first.unresolved > 50);
        CHECK(first.indices.size() <= 1500);
        CHECK(compare(rows_of(frames.resolve()), expected) == "");

        {
            votess::Progress stops([](double) { return false; });
            const votess::Stoppable stoppable(stops);
            gpu.device->table().vkWaitForFences = never_done;
            CHECK(test::error_of([&] { (void)run(frames); }) == ErrorCode::cancelled);
            gpu.device->table() = gpu.original;
        }
        CHECK(!frames.has_run());
        CHECK(run(frames).unresolved == first.unresolved);  // after the cancelled one
        CHECK(frames.has_run());
        gpu.device->table().vkQueueSubmit = lost;
        CHECK(test::error_of([&] { (void)run(frames); }) == ErrorCode::device_lost);
        CHECK(!frames.has_run());
        gpu.device->table() = gpu.original;
        CHECK(run(frames).unresolved == first.unresolved);

        const auto none = frames.run(std::span<const float>(), {});
        CHECK(none.status.empty());
        CHECK(none.indptr.size() == 1);
        CHECK(none.indices.empty());
        CHECK(compare(rows_of(frames.resolve()), on_cpu({"none", {}, set.box}, options)) == "");
    }
}
