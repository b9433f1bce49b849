#include "picture/vulkan/renderer.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <vector>

#include "gpu/device_choice.hpp"
#include "gpu/vulkan/memory.hpp"
#include "picture/vulkan/parts.hpp"
#include "picture/vulkan/pipelines.hpp"

namespace votess::gpu {
namespace {

using picture::FillVertex;
using picture::Scene;
using picture::Stroke;
using vulkan::check;

// Vertices or strokes in buffers of what the device can take at once.
struct Batch {
    vulkan::Buffer buffer;
    std::uint32_t count;
};

template <class T>
std::vector<Batch> upload(vulkan::Memory& memory, const std::vector<T>& items, std::size_t group, const char* name) {
    constexpr std::size_t most_bytes = std::size_t{32} << 20;
    const std::size_t most = std::min<std::size_t>(most_bytes, memory.max_buffer_bytes()) / sizeof(T) / group * group;
    std::vector<Batch> batches;
    for (std::size_t begin = 0; begin < items.size(); begin += most) {
        const std::size_t count = std::min(most, items.size() - begin);
        Batch batch{memory.buffer(count * sizeof(T), vulkan::MemoryKind::upload, name),
                    static_cast<std::uint32_t>(count)};
        std::memcpy(batch.buffer.mapped().data(), items.data() + begin, count * sizeof(T));
        batch.buffer.flush();
        batches.push_back(std::move(batch));
    }
    return batches;
}

class Renderer {
public:
    Renderer(vulkan::Device& device, const Scene& scene)
        : device_(device),
          table_(device.table()),
          scene_(scene),
          memory_(device),
          formats_(device),
          passes_(device, formats_),
          pipelines_(device, passes_),
          solid_(upload(memory_, scene.solid, 3, "picture_solid")),
          flat_(upload(memory_, scene.flat, 3, "picture_flat")),
          strokes_(upload(memory_, scene.strokes, 1, "picture_strokes")) {
        make_commands();
        make_set();
    }

    // Draws a part and puts it into the picture.
    void draw(const PicturePart& part, Picture& picture) {
        const VkExtent2D size{part.draw_w, part.draw_h};
        if (!images_ || images_->size.width != size.width || images_->size.height != size.height) {
            images_.reset();  // before others take memory
            images_.emplace(device_, formats_, passes_, size);
            result_ = {};
            result_ = memory_.buffer(VkDeviceSize{4} * size.width * size.height, vulkan::MemoryKind::download,
                                     "picture_result");
            point_set();
        }
        record(part);
        check(table_.vkResetFences(device_.handle(), 1, fence_.out()), "vkResetFences");
        device_.submit(commands_, fence_.get());
        wait();
        result_.invalidate();
        const auto pixels = result_.as<std::uint8_t>();
        for (std::uint32_t row = 0; row < part.height; ++row) {
            const std::size_t from =
                std::size_t{4} * ((part.top + row - part.draw_top) * size.width + part.left - part.draw_left);
            const std::size_t to = std::size_t{4} * (std::size_t{part.top + row} * picture.width + part.left);
            std::memcpy(&picture.pixels[to], &pixels[from], std::size_t{4} * part.width);
        }
    }

private:
    void make_commands() {
        pool_ = OwnedCommandPool(device_);
        VkCommandPoolCreateInfo pool{};
        pool.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
        pool.queueFamilyIndex = device_.adapter().queue_family;
        check(table_.vkCreateCommandPool(device_.handle(), &pool, nullptr, pool_.out()), "vkCreateCommandPool");
        VkCommandBufferAllocateInfo buffer{};
        buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
        buffer.commandPool = pool_.get();
        buffer.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
        buffer.commandBufferCount = 1;
        check(table_.vkAllocateCommandBuffers(device_.handle(), &buffer, &commands_), "vkAllocateCommandBuffers");
        fence_ = OwnedFence(device_);
        VkFenceCreateInfo fence{};
        fence.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO;
        check(table_.vkCreateFence(device_.handle(), &fence, nullptr, fence_.out()), "vkCreateFence");
    }

    void make_set() {
        const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 2};
        VkDescriptorPoolCreateInfo pool{};
        pool.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
        pool.maxSets = 1;
        pool.poolSizeCount = 1;
        pool.pPoolSizes = &size;
        set_pool_ = OwnedDescriptorPool(device_);
        check(table_.vkCreateDescriptorPool(device_.handle(), &pool, nullptr, set_pool_.out()),
              "vkCreateDescriptorPool");
        const VkDescriptorSetLayout layout = pipelines_.set_layout.get();
        VkDescriptorSetAllocateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
        info.descriptorPool = set_pool_.get();
        info.descriptorSetCount = 1;
        info.pSetLayouts = &layout;
        check(table_.vkAllocateDescriptorSets(device_.handle(), &info, &set_), "vkAllocateDescriptorSets");
    }

    void point_set() {
        const VkImageView views[2] = {images_->surface.view.get(), images_->occlusion.view.get()};
        VkDescriptorImageInfo infos[2]{};
        VkWriteDescriptorSet writes[2]{};
        for (std::uint32_t i = 0; i < 2; ++i) {
            infos[i] = {pipelines_.sampler.get(), views[i], VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            writes[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
            writes[i].dstSet = set_;
            writes[i].dstBinding = i;
            writes[i].descriptorCount = 1;
            writes[i].descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
            writes[i].pImageInfo = &infos[i];
        }
        table_.vkUpdateDescriptorSets(device_.handle(), 2, writes, 0, nullptr);
    }

    void begin_pass(const OwnedRenderPass& pass, const OwnedFramebuffer& frame, const VkClearColorValue& color) {
        VkClearValue clear[2]{};
        clear[0].color = color;
        clear[1].depthStencil = {1, 0};
        const VkExtent2D size = images_->size;
        VkRenderPassBeginInfo info{};
        info.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO;
        info.renderPass = pass.get();
        info.framebuffer = frame.get();
        info.renderArea = {{0, 0}, size};
        info.clearValueCount = 2;
        info.pClearValues = clear;
        table_.vkCmdBeginRenderPass(commands_, &info, VK_SUBPASS_CONTENTS_INLINE);
        const VkViewport viewport{0, 0, static_cast<float>(size.width), static_cast<float>(size.height), 0, 1};
        table_.vkCmdSetViewport(commands_, 0, 1, &viewport);
        table_.vkCmdSetScissor(commands_, 0, 1, &info.renderArea);
    }

    void bind(const OwnedPipeline& pipeline, const PicturePush& push) {
        table_.vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline.get());
        table_.vkCmdPushConstants(commands_, pipelines_.layout.get(),
                                  VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
    }

    void draw_fills(const std::vector<Batch>& batches) {
        for (const Batch& batch : batches) {
            const VkBuffer buffer = batch.buffer.handle();
            const VkDeviceSize begin = 0;
            table_.vkCmdBindVertexBuffers(commands_, 0, 1, &buffer, &begin);
            table_.vkCmdDraw(commands_, batch.count, 1, 0, 0);
        }
    }

    void draw_strokes(const std::vector<Batch>& batches) {
        for (const Batch& batch : batches) {
            const VkBuffer buffer = batch.buffer.handle();
            const VkDeviceSize begin = 0;
            table_.vkCmdBindVertexBuffers(commands_, 0, 1, &buffer, &begin);
            table_.vkCmdDraw(commands_, 6, batch.count, 0, 0);
        }
    }

    void record(const PicturePart& part) {
        check(table_.vkResetCommandPool(device_.handle(), pool_.get(), 0), "vkResetCommandPool");
        VkCommandBufferBeginInfo info{};
        info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
        info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
        check(table_.vkBeginCommandBuffer(commands_, &info), "vkBeginCommandBuffer");
        const PicturePush in_space = push_for(scene_, part, false), on_paper = push_for(scene_, part, true);
        if (!solid_.empty()) {
            begin_pass(passes_.surface, images_->surface_frame, {});
            bind(pipelines_.surface, in_space);
            draw_fills(solid_);
            table_.vkCmdEndRenderPass(commands_);

            begin_pass(passes_.occlusion, images_->occlusion_frame, {});
            table_.vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_GRAPHICS, pipelines_.layout.get(), 0, 1,
                                           &set_, 0, nullptr);
            bind(pipelines_.occlusion, in_space);
            table_.vkCmdDraw(commands_, 3, 1, 0, 0);
            table_.vkCmdEndRenderPass(commands_);
        }
        VkClearColorValue background{};
        for (std::size_t k = 0; k < 4; ++k) background.float32[k] = static_cast<float>(scene_.background[k]) / 255;
        begin_pass(passes_.color, images_->color_frame, background);
        if (!solid_.empty()) {
            bind(pipelines_.solid, in_space);
            draw_fills(solid_);
        }
        bind(pipelines_.flat, on_paper);
        draw_fills(flat_);
        bind(pipelines_.stroke, on_paper);
        draw_strokes(strokes_);
        table_.vkCmdEndRenderPass(commands_);
        record_download();
        check(table_.vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
    }

    void record_download() {
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = {images_->size.width, images_->size.height, 1};
        table_.vkCmdCopyImageToBuffer(commands_, images_->color.image.get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                      result_.handle(), 1, &copy);
        VkMemoryBarrier barrier{};
        barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
        barrier.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        table_.vkCmdPipelineBarrier(commands_, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                                    &barrier, 0, nullptr, 0, nullptr);
    }

    void wait() {
        constexpr std::uint64_t slice = 500'000'000;  // some drivers notice a lost device only when asked again
        for (VkResult result = VK_TIMEOUT; result == VK_TIMEOUT;) {
            result = table_.vkWaitForFences(device_.handle(), 1, fence_.out(), VK_TRUE, slice);
            if (result < 0) device_.drain();
            check(result, "vkWaitForFences");
        }
    }

    vulkan::Device& device_;
    VolkDeviceTable& table_;
    const Scene& scene_;
    vulkan::Memory memory_;
    Formats formats_;
    RenderPasses passes_;
    Pipelines pipelines_;
    std::vector<Batch> solid_, flat_, strokes_;
    OwnedDescriptorPool set_pool_;
    VkDescriptorSet set_ = VK_NULL_HANDLE;  // of the pool
    OwnedCommandPool pool_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;  // of the pool
    OwnedFence fence_;
    std::optional<Images> images_;
    vulkan::Buffer result_;
};

}  // namespace

Picture draw(const Scene& scene, const std::shared_ptr<vulkan::Device>& device, const DrawLimits& limits) {
    const VkPhysicalDeviceLimits& own = device->adapter().limits;
    const std::uint32_t most =
        std::min({limits.most_pixels, own.maxImageDimension2D, own.maxFramebufferWidth, own.maxFramebufferHeight});
    Picture picture;
    picture.width = scene.width;
    picture.height = scene.height;
    picture.pixels.resize(std::size_t{4} * scene.width * scene.height);
    picture.device = device->adapter().name;
    Renderer renderer(*device, scene);
    for (const PicturePart& part : cut_picture(scene, most)) renderer.draw(part, picture);
    return picture;
}

Picture draw(const Scene& scene, const std::string& device) {
    const auto chosen = choose_graphics_device(device);
    Picture picture = draw(scene, chosen);
    // The validation layer's findings are bugs, whatever the result.
    const auto messages = chosen->instance().take_messages();
    if (!messages.empty()) throw Error(ErrorCode::internal, "Vulkan validation found: " + messages.front());
    return picture;
}

}  // namespace votess::gpu
