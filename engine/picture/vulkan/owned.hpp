// A Vulkan object that is destroyed with its owner.
#pragma once

#include <utility>

#include "gpu/vulkan/device.hpp"

namespace votess::gpu {

// Destroy: the entry of the device's table, as &VolkDeviceTable::vkDestroyImage.
template <class Handle, auto Destroy>
class Owned {
public:
    Owned() = default;
    explicit Owned(vulkan::Device& device) : device_(&device) {}
    Owned(Owned&& other) noexcept
        : device_(std::exchange(other.device_, nullptr)), handle_(std::exchange(other.handle_, VK_NULL_HANDLE)) {}
    Owned& operator=(Owned&& other) noexcept {
        std::swap(device_, other.device_);
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Owned() {
        if (handle_ != VK_NULL_HANDLE) (device_->table().*Destroy)(device_->handle(), handle_, nullptr);
    }

    [[nodiscard]] Handle get() const { return handle_; }
    // Where Vulkan's call writes the new object.
    [[nodiscard]] Handle* out() { return &handle_; }

private:
    vulkan::Device* device_ = nullptr;
    Handle handle_ = VK_NULL_HANDLE;
};

using OwnedImage = Owned<VkImage, &VolkDeviceTable::vkDestroyImage>;
using OwnedImageView = Owned<VkImageView, &VolkDeviceTable::vkDestroyImageView>;
using OwnedMemory = Owned<VkDeviceMemory, &VolkDeviceTable::vkFreeMemory>;
using OwnedSampler = Owned<VkSampler, &VolkDeviceTable::vkDestroySampler>;
using OwnedRenderPass = Owned<VkRenderPass, &VolkDeviceTable::vkDestroyRenderPass>;
using OwnedFramebuffer = Owned<VkFramebuffer, &VolkDeviceTable::vkDestroyFramebuffer>;
using OwnedShader = Owned<VkShaderModule, &VolkDeviceTable::vkDestroyShaderModule>;
using OwnedPipeline = Owned<VkPipeline, &VolkDeviceTable::vkDestroyPipeline>;
using OwnedPipelineLayout = Owned<VkPipelineLayout, &VolkDeviceTable::vkDestroyPipelineLayout>;
using OwnedSetLayout = Owned<VkDescriptorSetLayout, &VolkDeviceTable::vkDestroyDescriptorSetLayout>;
using OwnedDescriptorPool = Owned<VkDescriptorPool, &VolkDeviceTable::vkDestroyDescriptorPool>;
using OwnedCommandPool = Owned<VkCommandPool, &VolkDeviceTable::vkDestroyCommandPool>;
using OwnedFence = Owned<VkFence, &VolkDeviceTable::vkDestroyFence>;

}  // namespace votess::gpu
