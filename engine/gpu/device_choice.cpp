#include "gpu/device_choice.hpp"

#include <algorithm>
#include <atomic>

#include "gpu/passes/kernel_choice.hpp"

namespace votess::gpu {
namespace {

using vulkan::Adapter;

int rank(const Adapter& adapter) {
    switch (adapter.type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return 0;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return 1;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return 2;
        default:
            return 3;
    }
}

// Returns names of devices with a reason each, for a message.
std::string with_reasons(const std::vector<Adapter>& adapters, bool software) {
    std::string text;
    for (const Adapter& a : adapters) {
        if (a.software() != software) continue;
        text += (text.empty() ? "" : ", ") + a.name;
        if (!a.missing().empty()) text += " (" + a.missing() + ")";
    }
    return text;
}

const Adapter* first_usable(const std::vector<Adapter>& adapters, bool software) {
    const Adapter* best = nullptr;
    for (const Adapter& a : adapters)
        if (a.software() == software && a.missing().empty() && (best == nullptr || rank(a) < rank(*best))) best = &a;
    return best;
}

[[noreturn]] void refuse(const std::string& device, const std::string& why) {
    throw Error(ErrorCode::unsupported, "device '" + device + "' is not available: " + why);
}

const Adapter* choose(const std::string& device, const std::vector<Adapter>& adapters) {
    if (device == "auto") return first_usable(adapters, false);
    if (adapters.empty()) refuse(device, "no Vulkan driver on this machine");
    if (device == "gpu" || device == "lavapipe") {
        const bool software = device == "lavapipe";
        if (const Adapter* found = first_usable(adapters, software)) return found;
        const std::string same = with_reasons(adapters, software), others = with_reasons(adapters, !software);
        if (!same.empty()) refuse(device, same);
        refuse(device, software ? "no Vulkan device is software, there is " + others
                                : "no Vulkan device is a GPU, there is " + others + " (use lavapipe or cpu)");
    }
    const auto index = static_cast<std::size_t>(std::stoul(device));
    if (index >= adapters.size()) refuse(device, "the Vulkan devices are 0 to " + std::to_string(adapters.size() - 1));
    if (!adapters[index].missing().empty()) refuse(device, adapters[index].name + " " + adapters[index].missing());
    return &adapters[index];
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
    std::vector<DeviceInfo> all;
    try {
        for (const Adapter& a : vulkan::Instance::create()->adapters()) {
            std::string text = a.description() + "; ";
            if (const std::string missing = a.missing(); !missing.empty())
                text += "not usable: " + missing;
            else
                text += kernel_text(a, choose_subgroup_size(a, Kernel::automatic),
                                    measures_in_float64(a, a.float64, Measure::automatic));
            all.push_back({std::to_string(all.size()), a.name, text});
        }
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) throw;  // this machine has no Vulkan
    }
    return all;
}

std::shared_ptr<vulkan::Device> choose_device(const std::string& device) {
    // Finding that a machine has no GPU takes 40 ms, so it is done once a process.
    static std::atomic<bool> no_gpu = false;
    if (device == "auto" && no_gpu) return nullptr;
    std::shared_ptr<vulkan::Instance> instance;
    try {
        instance = vulkan::Instance::create();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) throw;
        if (device != "auto") refuse(device, error.what());
        no_gpu = true;
        return nullptr;
    }
    const auto adapters = instance->adapters();
    const Adapter* adapter = choose(device, adapters);
    if (adapter == nullptr) {
        no_gpu = true;
        return nullptr;
    }
    return vulkan::Device::create(instance, *adapter);
}

}  // namespace votess::gpu
