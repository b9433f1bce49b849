// A compute pipeline.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu::vulkan {

// A specialization constant, its value as raw bits.
struct Constant {
    std::uint32_t id, value;
    bool operator==(const Constant&) const = default;
};

struct PassInfo {
    const char* name = "";
    std::span<const std::uint32_t> spirv;  // declares storage buffers of set 0, which the pass binds
    std::uint32_t push_bytes = 0;          // size of the push constants, a multiple of 4
    std::uint32_t local_size = 64;         // invocations of a work-group, all along x: CONSTANT_LOCAL_SIZE
    std::vector<Constant> constants = {};  // all others that the shader declares
    std::uint32_t subgroup_size = 0;       // requested where the device allows that; 0 = any
};

// Copies share the pipeline. Throws `unsupported` where the device's limits are too small, `internal` where the
// constants are not those of the shader.
class Pass {
public:
    Pass() = default;  // none
    Pass(Device& device, const PassInfo& info);

    [[nodiscard]] explicit operator bool() const { return made_ != nullptr; }
    [[nodiscard]] const std::string& name() const { return made_->name; }
    [[nodiscard]] VkPipeline pipeline() const { return made_->pipeline; }
    [[nodiscard]] VkPipelineLayout layout() const { return made_->layout; }
    [[nodiscard]] VkDescriptorSetLayout set_layout() const { return made_->set_layout; }
    [[nodiscard]] std::span<const std::uint32_t> bindings() const { return made_->bindings; }  // ascending
    [[nodiscard]] std::uint32_t push_bytes() const { return made_->push_bytes; }
    [[nodiscard]] std::uint32_t local_size() const { return made_->local_size; }
    [[nodiscard]] bool is_shared() const { return made_.use_count() > 1; }

private:
    struct Made {
        Made(Device& device, const PassInfo& info);  // all but the pipeline
        ~Made();
        Made(const Made&) = delete;
        Made& operator=(const Made&) = delete;
        void make_layout();
        void make_pipeline(const PassInfo& info);
        void destroy() const noexcept;

        Device& device;
        std::string name;
        std::vector<std::uint32_t> bindings;
        std::uint32_t push_bytes;
        std::uint32_t local_size;
        VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
        VkPipelineLayout layout = VK_NULL_HANDLE;
        VkPipeline pipeline = VK_NULL_HANDLE;
    };
    friend class PassBatch;
    explicit Pass(std::shared_ptr<Made> made) : made_(std::move(made)) {}

    std::shared_ptr<Made> made_;
};

// The passes of a device. A driver may take seconds to make one, so a run with other options makes only the passes that
// these change. Keeps the last max_unused passes that nobody uses. Thread-safe.
class PassCache {
private:
    friend class PassBatch;
    struct Known {
        PassInfo info;
        Pass pass;
    };
    static constexpr std::size_t max_unused = 64;

    std::mutex mutex_;
    std::vector<Known> known_;  // the last requested one is at the end
};

// Gets passes from the cache of a device, and makes those that it lacks side by side. During its life no other thread
// gets passes of the device.
class PassBatch {
public:
    explicit PassBatch(vulkan::Device& device);
    ~PassBatch();  // the cache forgets passes without a pipeline
    PassBatch(const PassBatch&) = delete;
    PassBatch& operator=(const PassBatch&) = delete;

    [[nodiscard]] vulkan::Device& device() { return device_; }
    // Returns a pass that has no pipeline before make(). Throws as Pass().
    [[nodiscard]] Pass get(const PassInfo& info);
    // Makes the pipelines that are missing. Throws the first error; the others may then be missing still.
    void make();

private:
    vulkan::Device& device_;
    PassCache& cache_;
    std::lock_guard<std::mutex> lock_;
};

}  // namespace votess::gpu::vulkan
