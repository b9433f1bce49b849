// A device for tests. Its destructor checks that Vulkan was not misused.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu/vulkan/commands.hpp"
#include "support/at_end.hpp"
#include "support/check.hpp"
#include "test_shaders.hpp"

namespace test {

namespace vk = votess::gpu::vulkan;

// Sets or unsets an environment variable during its life.
class Environment {
public:
    Environment(const char* name, const char* value) : name_(name) {
        if (const char* old = std::getenv(name)) old_ = old;
        value ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Environment() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

private:
    const char* name_;
    std::optional<std::string> old_;
};

// The first device that votess can use, with validation where VOTESS_VULKAN_VALIDATION requests it.
struct Gpu {
    std::shared_ptr<vk::Instance> instance = vk::Instance::create();
    vk::Adapter adapter = first(*instance);
    std::shared_ptr<vk::Device> device;
    const VolkDeviceTable original;  // before a test replaced entries

    explicit Gpu(const vk::DeviceOptions& options = {}) : Gpu(options, [](VkPhysicalDeviceLimits&) {}) {}
    // lower(limits) lowers limits of the device.
    Gpu(const vk::DeviceOptions& options, const auto& lower)
        : device(vk::Device::create(instance, with_lower(adapter, lower), options)), original(device->table()) {}
    ~Gpu() {
        device->table() = original;
        device.reset();
        check_messages();
    }

    void check_messages() const {
        for (const std::string& message : instance->take_messages()) FAIL_CHECK(message);
    }

    // Runs one pass, and waits until the host may read its output.
    void run(const vk::Pass& pass, std::span<const vk::BufferBinding> bindings, std::span<const std::byte> push,
             std::uint32_t invocations) const {
        vk::Commands commands(*device);
        commands.begin();
        commands.dispatch(pass, bindings, push, invocations);
        commands.barrier_to_host();
        commands.end();
        commands.submit();
        commands.wait();
    }

    static const vk::Adapter& with_lower(vk::Adapter& adapter, const auto& lower) {
        lower(adapter.limits);
        return adapter;
    }

    static vk::Adapter first(const vk::Instance& instance) {
        const auto adapters = instance.adapters();
        const auto it =
            std::find_if(adapters.begin(), adapters.end(), [](const auto& a) { return a.missing().empty(); });
        REQUIRE_MESSAGE(it != adapters.end(), "no usable Vulkan device; Mesa's lavapipe will do");
        return *it;
    }
};

// The device that the tests of a process share: it keeps pipelines, which take seconds to make. Tests that replace
// entries of its table take a Gpu of their own.
struct SharedGpu {
    Gpu& gpu = shared();
    SharedGpu() = default;
    ~SharedGpu() { gpu.check_messages(); }
    SharedGpu(const SharedGpu&) = delete;
    SharedGpu& operator=(const SharedGpu&) = delete;

private:
    static Gpu& shared() {
        // Validation layers 1.4.363 destroy their globals before those of the tests.
        static std::optional<Gpu> gpu;
        if (!gpu) {
            gpu.emplace();
            at_end([] { gpu.reset(); });
        }
        return *gpu;
    }
};

struct ScalePush {
    std::uint32_t count;
    std::uint32_t addend;
};

// target[i] += source[i] * factor / divisor + addend
inline vk::PassInfo scale_info(std::uint32_t local_size, std::uint32_t factor = 1, std::uint32_t divisor = 1) {
    vk::PassInfo info;
    info.name = "test_scale";
    info.spirv = votess::gpu::shaders::test_scale;
    info.push_bytes = sizeof(ScalePush);
    info.local_size = local_size;
    info.constants = {{1, factor}, {2, divisor}};
    return info;
}
inline vk::Pass scale_pass(vk::Device& device, std::uint32_t local_size, std::uint32_t factor = 1,
                           std::uint32_t divisor = 1) {
    return vk::Pass(device, scale_info(local_size, factor, divisor));
}

}  // namespace test
