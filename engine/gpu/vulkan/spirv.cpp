#include "gpu/vulkan/spirv.hpp"

#include <algorithm>
#include <cstring>
#include <initializer_list>
#include <string_view>

namespace votess::gpu::vulkan {
namespace {

// A module is a header and instructions. The first word of an instruction holds its length and its operation.
constexpr std::size_t header_words = 5;
enum Operation : std::uint32_t {
    op_extension = 10,
    op_entry_point = 15,
    op_execution_mode = 16,
    op_capability = 17,
    op_function = 54,
    op_decorate = 71
};
constexpr std::uint32_t capability_float64 = 10;

// A demand is a capability of the module and an execution mode of each entry point and width.
struct Demand {
    std::uint32_t capability, mode;
    bool float32, float64;
};

// Calls `each` with each instruction before the first function: these are all declarations.
template <class Each>
void for_each_declaration(std::span<const std::uint32_t> spirv, Each each) {
    for (std::size_t at = header_words; at < spirv.size() && (spirv[at] & 0xffffu) != op_function;
         at += spirv[at] >> 16)
        each(spirv.subspan(at, spirv[at] >> 16));
}

void append(std::vector<std::uint32_t>& module, Operation operation, std::initializer_list<std::uint32_t> operands) {
    module.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | operation);
    module.insert(module.end(), operands);
}

void append_extension(std::vector<std::uint32_t>& module, std::string_view name) {
    const std::size_t words = name.size() / 4 + 1;  // with a 0 at the end
    module.push_back(static_cast<std::uint32_t>(words + 1) << 16 | op_extension);
    module.resize(module.size() + words);
    std::memcpy(&module[module.size() - words], name.data(), name.size());
}

}  // namespace

std::vector<std::uint32_t> declared(std::span<const std::uint32_t> spirv, Decoration decoration) {
    std::vector<std::uint32_t> values;
    for_each_declaration(spirv, [&](std::span<const std::uint32_t> words) {
        if ((words[0] & 0xffffu) == op_decorate && words[2] == static_cast<std::uint32_t>(decoration))
            values.push_back(words[3]);
    });
    std::ranges::sort(values);
    return values;
}

std::vector<std::uint32_t> with_demands(std::span<const std::uint32_t> spirv, FloatDemands demands) {
    bool has_float64 = false;
    for_each_declaration(spirv, [&](std::span<const std::uint32_t> words) {
        has_float64 = has_float64 || ((words[0] & 0xffffu) == op_capability && words[1] == capability_float64);
    });
    std::vector<Demand> made{{4467, 4462, demands.nearest32, demands.nearest64 && has_float64},
                             {4466, 4461, demands.infinities32, demands.infinities64 && has_float64}};
    std::erase_if(made, [](const Demand& d) { return !d.float32 && !d.float64; });
    std::vector<std::uint32_t> module(spirv.begin(), spirv.end());
    if (made.empty()) return module;
    // The order of declarations is: capabilities, extensions, others, entry points, their modes, others.
    module.resize(header_words);
    std::size_t at = header_words;
    for_each_declaration(spirv, [&](std::span<const std::uint32_t> words) {
        const std::uint32_t operation = words[0] & 0xffffu;
        module.insert(module.end(), words.begin(), words.end());
        at += words.size();
        const std::uint32_t next = spirv[at] & 0xffffu;
        if (operation == op_capability && next != op_capability) {
            for (const Demand& d : made) append(module, op_capability, {d.capability});
            append_extension(module, "SPV_KHR_float_controls");
        }
        if (operation != op_entry_point) return;
        for (const Demand& d : made) {
            if (d.float32) append(module, op_execution_mode, {words[2], d.mode, 32});
            if (d.float64) append(module, op_execution_mode, {words[2], d.mode, 64});
        }
    });
    module.insert(module.end(), spirv.begin() + static_cast<std::ptrdiff_t>(at), spirv.end());
    return module;
}

}  // namespace votess::gpu::vulkan
