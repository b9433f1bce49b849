#include "engines.hpp"

#include <algorithm>
#include <optional>
#include <thread>

#include "cpu/cpu_engine.hpp"
#include "cpu/kernels.hpp"
#if VOTESS_HAVE_VULKAN
#include "gpu/device_choice.hpp"
#include "gpu/gpu_engine.hpp"
#endif

namespace votess {

struct Engines::State {
    cpu::CpuClipper clipper;  // and its threads, for both engines
    cpu::CpuEngine cpu{clipper};
#if VOTESS_HAVE_VULKAN
    std::optional<gpu::GpuEngine> gpu;
    std::string gpu_name;  // the device name that chose it
#endif
};

Engines::Engines() : state_(std::make_unique<State>()) {}
Engines::~Engines() = default;

Engine& Engines::cpu() {
    return state_->cpu;
}

#if VOTESS_HAVE_VULKAN

Engine& Engines::choose(const std::string& device) {
    if (device == "cpu") return state_->cpu;
    if (state_->gpu && state_->gpu_name == device) return *state_->gpu;
    auto chosen = gpu::choose_device(device);
    if (!chosen) return state_->cpu;
    state_->gpu.emplace(std::move(chosen), state_->clipper);
    state_->gpu_name = device;
    return *state_->gpu;
}

void Engines::forget_gpu() {
    state_->gpu.reset();
}

#else

Engine& Engines::choose(const std::string& device) {
    if (device != "cpu" && device != "auto")
        throw Error(ErrorCode::unsupported, "device '" + device + "': this votess was built without Vulkan, use cpu");
    return state_->cpu;
}

void Engines::forget_gpu() {}

#endif

std::vector<DeviceInfo> Engines::devices() {
    const unsigned threads = std::max(1u, std::thread::hardware_concurrency());
    std::vector<DeviceInfo> all{{"cpu", "CPU",
                                 std::to_string(threads) + (threads == 1 ? " thread, " : " threads, ") +
                                     cpu::best_kernels().name + " instructions, exact in double precision"}};
#if VOTESS_HAVE_VULKAN
    const auto vulkan = gpu::list_devices();
    all.insert(all.end(), vulkan.begin(), vulkan.end());
#endif
    return all;
}

}  // namespace votess
