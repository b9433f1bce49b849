#include "gpu/passes/kernel_choice.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <string_view>

namespace votess::gpu {
namespace {

constexpr std::uint32_t min_lanes = 8, max_lanes = 64;
constexpr std::uint32_t amd = 0x1002, intel = 0x8086;

// With 32 lanes each has two vertices, and few cells have more than 64. Intel's registers hold 16 lanes with four
// vertices each; 32 lanes spill.
std::uint32_t lanes_of(const vulkan::Adapter& adapter) {
    if (!adapter.subgroup_size_control) return adapter.subgroup_size;
    const std::uint32_t best = adapter.vendor_id == intel ? 16 : 32;
    return std::clamp(best, adapter.min_subgroup_size, adapter.max_subgroup_size);
}

std::string_view environment(const char* name) {
    const char* text = std::getenv(name);
    return text == nullptr ? "" : text;
}

// Vulkan does not report how fast float64 is. These GPUs and CPUs run it at half the rate of float32 (Radeon VII at a
// quarter), all others at 1/16 to 1/64.
constexpr std::array fast_float64{"P100",   "GP100",  "V100",   "GV100",     "TITAN V", "A100",  "A800",
                                  "A30",    "H100",   "H200",   "H800",      "GH200",   "B100",  "B200",
                                  "GB200",  "MI50",   "MI60",   "MI100",     "MI210",   "MI250", "MI250X",
                                  "MI300A", "MI300X", "MI325X", "Radeon VII"};

// Returns whether the text has these words, not as parts of longer ones.
bool has_words(std::string_view text, std::string_view words) {
    const auto ends_word = [&](std::size_t at) {
        return at >= text.size() || std::isalnum(static_cast<unsigned char>(text[at])) == 0;
    };
    for (std::size_t at = text.find(words); at != std::string_view::npos; at = text.find(words, at + 1))
        if (ends_word(at - 1) && ends_word(at + words.size())) return true;
    return false;
}

}  // namespace

std::string missing_for_subgroups(const vulkan::Adapter& adapter) {
    if (!adapter.subgroup_in_compute) return "subgroup operations in compute shaders";
    const struct {
        VkSubgroupFeatureFlags bit;
        const char* name;
    } needed[] = {{VK_SUBGROUP_FEATURE_BASIC_BIT, "basic"},
                  {VK_SUBGROUP_FEATURE_VOTE_BIT, "vote"},
                  {VK_SUBGROUP_FEATURE_BALLOT_BIT, "ballot"},
                  {VK_SUBGROUP_FEATURE_ARITHMETIC_BIT, "arithmetic"},
                  {VK_SUBGROUP_FEATURE_SHUFFLE_BIT, "shuffle"}};
    for (const auto& operations : needed)
        if ((adapter.subgroup_operations & operations.bit) == 0)
            return std::string(operations.name) + " operations of subgroups";
    // Where sizes vary and none was probed (Device::find_subgroup_size()), only AMD's drivers report one that shaders
    // have.
    if (!adapter.subgroup_size_control && adapter.min_subgroup_size != adapter.max_subgroup_size &&
        adapter.vendor_id != amd)
        return "control of the size of subgroups, which varies";
    const std::uint32_t lanes = lanes_of(adapter);
    if (lanes < min_lanes || lanes > max_lanes || !std::has_single_bit(lanes))
        return "subgroups of 8 to 64 invocations, it has " + std::to_string(lanes);
    return {};
}

std::uint32_t choose_subgroup_size(const vulkan::Adapter& adapter, Kernel kernel) {
    if (kernel == Kernel::invocation) return 0;
    const std::string missing = missing_for_subgroups(adapter);
    if (missing.empty()) {
        // On a CPU lanes are not threads. Subgroups are slower, or as fast and slower to compile (README.md).
        return kernel == Kernel::automatic && adapter.software() ? 0 : lanes_of(adapter);
    }
    if (kernel == Kernel::automatic) return 0;
    throw Error(ErrorCode::unsupported,
                "device '" + adapter.name + "' cannot run kernel subgroup: it lacks " + missing);
}

bool measures_in_float64(const vulkan::Adapter& adapter, bool has_float64, Measure measure) {
    if (measure == Measure::float64 && !has_float64)
        throw Error(ErrorCode::unsupported, "device '" + adapter.name + "' has no float64 to measure in");
    if (measure != Measure::automatic) return measure == Measure::float64;
    return has_float64 && (adapter.software() || std::ranges::any_of(fast_float64, [&](const char* words) {
                               return has_words(adapter.name, words);
                           }));
}

Measure measure_from_environment() {
    const std::string_view word = environment("VOTESS_VULKAN_MEASURE");
    if (word.empty() || word == "automatic") return Measure::automatic;
    if (word == "float64") return Measure::float64;
    if (word == "float32") return Measure::float32;
    throw Error(ErrorCode::invalid_argument,
                "VOTESS_VULKAN_MEASURE is '" + std::string(word) + "': give automatic, float64 or float32");
}

Kernel kernel_from_environment() {
    const std::string_view word = environment("VOTESS_VULKAN_KERNEL");
    if (word.empty() || word == "automatic") return Kernel::automatic;
    if (word == "invocation") return Kernel::invocation;
    if (word == "subgroup") return Kernel::subgroup;
    throw Error(ErrorCode::invalid_argument,
                "VOTESS_VULKAN_KERNEL is '" + std::string(word) + "': give automatic, invocation or subgroup");
}

std::string kernel_text(const vulkan::Adapter& adapter, std::uint32_t subgroup_size, bool measure_float64) {
    std::string text = "subgroups of " + std::to_string(subgroup_size) + " make cells";
    if (subgroup_size == 0) {
        const std::string missing = missing_for_subgroups(adapter);
        text = "invocations make cells";
        if (!missing.empty())
            text += ", as it lacks " + missing;
        else if (adapter.software())
            text += ", as suits a CPU";
    }
    return text + ", measured in " + (measure_float64 ? "float64" : "float32");
}

std::uint32_t local_size_from_environment() {
    const std::string_view word = environment("VOTESS_VULKAN_LOCAL_SIZE");
    if (word.empty()) return 0;
    std::uint32_t size = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), size);
    if (error != std::errc() || end != word.data() + word.size() || size > 1024 || !std::has_single_bit(size))
        throw Error(ErrorCode::invalid_argument,
                    "VOTESS_VULKAN_LOCAL_SIZE is '" + std::string(word) + "': give a power of two up to 1024");
    return size;
}

}  // namespace votess::gpu
