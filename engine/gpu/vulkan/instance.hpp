// The Vulkan loader and an instance of it.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/system.hpp"
#include "gpu/vulkan/adapter.hpp"
#include "gpu/vulkan/api.hpp"

namespace votess::gpu::vulkan {

// Returns whether the environment has VOTESS_VULKAN_VALIDATION=1, or 2, which also looks for missing barriers.
[[nodiscard]] bool validation_wanted();
[[nodiscard]] bool synchronization_validation_wanted();

// The Vulkan loader, opened at run time so that votess works on machines without it. Throws `unsupported` if absent.
class Loader {
public:
    Loader();
    Loader(const Loader&) = delete;
    Loader& operator=(const Loader&) = delete;

    [[nodiscard]] const LoaderCalls& calls() const { return calls_; }

private:
    system::SharedLibrary library_;
    LoaderCalls calls_;
};

struct InstanceOptions {
    bool validation = validation_wanted();
    bool synchronization = synchronization_validation_wanted();  // only with validation
};

// An instance of a host program.
struct HostInstance {
    VkInstance handle = VK_NULL_HANDLE;
    PFN_vkGetInstanceProcAddr get = nullptr;
    std::uint32_t version = VK_API_VERSION_1_1;
    bool debug_utils = false;
};

class Instance {
public:
    // Throws `unsupported` without a loader for Vulkan 1.1, and when validation is requested but its layer is missing.
    // A loader without any driver is not an error: there are no adapters then.
    [[nodiscard]] static std::shared_ptr<Instance> create(const InstanceOptions& options = {});
    // Borrows the instance, which the host destroys.
    [[nodiscard]] static std::shared_ptr<Instance> adopt(const HostInstance& host);
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;

    // Null when no driver is installed.
    [[nodiscard]] VkInstance handle() const { return handle_; }
    [[nodiscard]] const InstanceCalls& calls() const { return calls_; }
    [[nodiscard]] bool validation() const { return validation_; }
    [[nodiscard]] bool debug_utils() const { return debug_utils_; }
    [[nodiscard]] std::uint32_t version() const { return version_; }

    // Returns all physical devices in the loader's order, those that votess cannot use too (Adapter::missing).
    [[nodiscard]] std::vector<Adapter> adapters() const;
    // Returns the messages of the validation layer since the last call, each "error: ..." or "warning: ...".
    // Thread-safe.
    [[nodiscard]] std::vector<std::string> take_messages();
    // Throws `internal` if there are any: they are bugs, whatever the result.
    void check_messages();

private:
    explicit Instance(const InstanceOptions& options);
    explicit Instance(const HostInstance& host);
    void create_handle(const InstanceOptions& options);
    void load_calls(PFN_vkGetInstanceProcAddr get);
    void create_messenger();
    void destroy() noexcept;
    void add_message(std::string message);
    static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                     VkDebugUtilsMessageTypeFlagsEXT types,
                                                     const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

    std::optional<Loader> loader_;  // none: the host's instance
    VkInstance handle_ = VK_NULL_HANDLE;
    std::uint32_t version_ = 0;
    InstanceCalls calls_;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    bool validation_ = false;
    bool debug_utils_ = false;
    std::mutex mutex_;
    std::vector<std::string> messages_;
};

}  // namespace votess::gpu::vulkan
