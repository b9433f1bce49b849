// Cells stay the same with compilers that assume finite numbers: Vulkan allows that where a module does not forbid it.
#include <doctest/doctest.h>

#include "support/gpu/finite.hpp"
#include "support/gpu/gpu.hpp"

namespace {

using test::Instead;
using test::PointSet;

struct Variant {
    Instead number;
    votess::gpu::Kernel kernel;
    const char* measure;
};

PFN_vkCreateShaderModule real_create = nullptr;
Instead instead;

VKAPI_ATTR VkResult VKAPI_CALL create_finite(VkDevice device, const VkShaderModuleCreateInfo* info,
                                             const VkAllocationCallbacks* allocator, VkShaderModule* module) {
    const std::vector<std::uint32_t> words = test::with_finite_results({info->pCode, info->codeSize / 4}, instead);
    VkShaderModuleCreateInfo finite = *info;
    finite.codeSize = std::span(words).size_bytes();
    finite.pCode = words.data();
    return real_create(device, &finite, allocator, module);
}

// Sets with ties, flat cells, seeds at one place, far away, and few or none of some kinds.
std::vector<PointSet> samples() {
    return {test::uniform(300, 1),
            test::clustered(300, 2),
            test::nested_clusters(300, 3),
            test::near_duplicates(60, 4),
            test::far_from_origin(100, 5),
            test::on_walls(100, 6),
            test::with_duplicates(90, 9, 7),
            test::fcc(3),
            test::on_oblique_plane(100, 8),
            test::on_axis_line(50, 9),
            test::on_sphere_and_center(100, 10),
            test::uniform(1, 11),
            test::uniform(2, 12)};
}

}  // namespace

TEST_SUITE("cases") {
    TEST_CASE("gpu finite: infinities and NaN may become any number") {
        for (const auto& [number, kernel, measure] :
             {Variant{Instead::largest, votess::gpu::Kernel::invocation, "float64"},
              {Instead::zero, test::by_subgroup(), "float32"}}) {
            instead = number;
            const test::UseKernel chosen(kernel);
            const test::Environment numbers("VOTESS_VULKAN_MEASURE", measure);
            test::Gpu gpu;
            real_create = gpu.device->table().vkCreateShaderModule;
            gpu.device->table().vkCreateShaderModule = create_finite;
            test::GpuRunner runner(gpu);
            for (const PointSet& set : samples()) {
                CAPTURE(std::string(measure));
                CAPTURE(set.name);
                const votess::Options options = test::all_options(set.box);
                const votess::Tessellation t = runner.run(set, options);
                CHECK(test::check_same(t, votess::tessellate(set.points, options), set.points,
                                       test::single_tolerance) == "");
                // The CPU would hide cells that the device can no longer make.
                if (set.name == "uniform") CHECK(t.stats().fallback_cells <= set.size() / 50);
            }
        }
    }
}
