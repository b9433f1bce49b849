#include "frames.hpp"

#include <algorithm>
#include <cstring>
#include <random>

namespace host {
namespace {

// Half of the seeds anywhere in the unit box, half around a ring in it. The fourth number is the seed's own phase.
std::vector<float> first_seeds(std::uint32_t count) {
    std::mt19937 random(20);
    const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24F; };
    std::vector<float> seeds;
    seeds.reserve(4 * static_cast<std::size_t>(count));
    for (std::uint32_t i = 0; i < count; ++i) {
        std::array<float, 3> p{};
        for (float& x : p) x = uniform();
        if (i % 2 == 1) {
            const float turn = 6.2831853F * p[0];
            const std::array<float, 3> ring{0.5F + 0.27F * std::cos(turn), 0.5F + 0.27F * std::sin(turn), 0.6F};
            // The sum of two is denser in the middle.
            for (std::size_t a = 0; a < 3; ++a) p[a] = ring[a] + 0.36F * (uniform() + uniform() - 1);
        }
        for (const float x : p) seeds.push_back(std::clamp(x, 0.0F, 1.0F));
        seeds.push_back(6.2831853F * uniform());
    }
    return seeds;
}

template <class T>
std::vector<T> numbers(std::span<const std::byte> bytes, VkDeviceSize offset, std::size_t count) {
    std::vector<T> result(count);
    if (count > 0) std::memcpy(result.data(), bytes.data() + offset, count * sizeof(T));
    return result;
}

}  // namespace

Frames::Frames(const HostDevice& device, std::span<const votess::vulkan::Plan> plans, const FrameOptions& options)
    : device_(device),
      plans_(plans),
      options_(options),
      moving_(device, in_flight),
      drawing_(device, options.width, options.height, in_flight),
      pool_(make_command_pool(device)) {
    VkDeviceSize seed_bytes = 16 * static_cast<VkDeviceSize>(options.seeds);
    for (const votess::vulkan::Plan& plan : plans) seed_bytes = std::max(seed_bytes, plan.sizes().seeds);
    for (Slot& slot : slots_) {
        slot.seeds = Buffer(device, seed_bytes, votess::vulkan::buffer_usage, Place::device);
        for (const votess::vulkan::Plan& plan : plans) slot.cells.push_back(make_cells(plan, slot.seeds.get()));
        slot.target = drawing_.make_target();
        slot.picture = Buffer(device, 4 * static_cast<VkDeviceSize>(options.width) * options.height,
                              VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::host);
        slot.commands = make_commands(device, pool_.get());
        slot.fence = make_fence(device);

        const votess::vulkan::Buffers& drawn = slot.cells.front().ranges;
        const votess::vulkan::BufferSizes& sizes = plans.front().sizes();
        slot.drawing = drawing_.set({{{drawn.seeds.buffer, drawn.seeds.offset, VK_WHOLE_SIZE},
                                      {drawn.cells.buffer, drawn.cells.offset, sizes.cells},
                                      {drawn.indices.buffer, drawn.indices.offset, sizes.indices},
                                      {drawn.geometry.buffer, drawn.geometry.offset, sizes.geometry}}});
    }
    for (std::size_t i = 0; i < in_flight; ++i) {
        slots_[i].moving = moving_.set(slots_[(i + in_flight - 1) % in_flight].seeds.get(), slots_[i].seeds.get());
    }
    // Frame 0 moves them from the last slot to the first.
    const std::vector<float> first = first_seeds(options.seeds);
    upload(device, std::as_bytes(std::span(first)), slots_.back().seeds.get());
}

Frames::~Frames() {
    for (const Slot& slot : slots_) {
        const VkFence fence = slot.fence.get();
        if (slot.pending) vkWaitForFences(device_.device(), 1, &fence, VK_TRUE, ~std::uint64_t{0});
    }
}

Frames::Cells Frames::make_cells(const votess::vulkan::Plan& plan, VkBuffer seeds) const {
    const votess::vulkan::BufferSizes& sizes = plan.sizes();
    const VkDeviceSize alignment = device_.properties().limits.minStorageBufferOffsetAlignment;
    VkDeviceSize end = 0;
    const auto place = [&](VkDeviceSize bytes) {
        const VkDeviceSize offset = end;
        end += (bytes + alignment - 1) / alignment * alignment;
        return offset;
    };
    const VkDeviceSize header = place(sizes.header), cells = place(sizes.cells), indices = place(sizes.indices),
                       geometry = place(sizes.geometry);
    Cells made;
    made.workspace = Buffer(device_, sizes.workspace, votess::vulkan::buffer_usage, Place::device);
    made.results = Buffer(device_, end, votess::vulkan::buffer_usage, Place::device);
    const VkBuffer buffer = made.results.get();
    made.ranges = {
        .seeds = {seeds, 0},
        .workspace = {made.workspace.get(), 0},
        .header = {buffer, header},
        .cells = {buffer, cells},
        .indices = {buffer, indices},
        .geometry = sizes.geometry > 0 ? votess::vulkan::BufferRange{buffer, geometry} : votess::vulkan::BufferRange{}};
    made.frame = plan.frame(made.ranges);
    return made;
}

void Frames::submit(std::uint32_t frame) {
    Slot& slot = slots_[frame % in_flight];
    record(slot, frame);
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &slot.commands;
    const VkFence fence = slot.fence.get();
    check(vkResetFences(device_.device(), 1, &fence), "vkResetFences");
    check(vkQueueSubmit(device_.queue(), 1, &submit, fence), "vkQueueSubmit");
    slot.pending = true;
}

void Frames::record(const Slot& slot, std::uint32_t frame) const {
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(slot.commands, &begin), "vkBeginCommandBuffer");

    constexpr float step = 0.02F;
    moving_.record(slot.commands, slot.moving,
                   {.count = options_.seeds, .time = step * static_cast<float>(frame), .step = step});
    // For votess, the drawing, and the next frame's move, which reads these seeds and overwrites those it came from.
    barrier(slot.commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
            VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
            VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);

    for (const Cells& cells : slot.cells) cells.frame.record(slot.commands, {.count = options_.seeds});

    drawing_.record(slot.commands, slot.drawing, slot.target, view(frame));
    drawing_.record_copy(slot.commands, slot.target, slot.picture.get());
    barrier(slot.commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
            VK_ACCESS_HOST_READ_BIT);
    check(vkEndCommandBuffer(slot.commands), "vkEndCommandBuffer");
}

std::span<const std::byte> Frames::wait_for(std::uint32_t frame) {
    Slot& slot = slots_[frame % in_flight];
    wait(device_, slot.fence.get());
    slot.pending = false;
    return slot.picture.mapped();
}

DrawPush Frames::view(std::uint32_t frame) const {
    DrawPush push = drawing_.view(-0.95F + 0.002F * static_cast<float>(frame));
    push.count = options_.seeds;
    push.samples = options_.samples;
    return push;
}

std::vector<std::uint32_t> Frames::cells_seen(std::uint32_t frame) const {
    const Slot& slot = slots_[frame % in_flight];
    const std::size_t pixels = static_cast<std::size_t>(options_.width) * options_.height;
    const Buffer copy(device_, 4 * pixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::host);
    DrawPush push = view(frame);
    push.samples = 0;
    run_once(device_, [&](VkCommandBuffer commands) {
        drawing_.record(commands, slot.drawing, slot.target, push);
        drawing_.record_copy(commands, slot.target, copy.get());
        barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
                VK_ACCESS_HOST_READ_BIT);
    });
    std::vector<std::uint32_t> seen;
    seen.reserve(pixels);
    for (std::size_t i = 0; i < 4 * pixels; i += 4) {
        const auto byte = [&](std::size_t b) { return std::to_integer<std::uint32_t>(copy.mapped()[i + b]); };
        seen.push_back(byte(0) | byte(1) << 8 | byte(2) << 16 | byte(3) << 24);
    }
    return seen;
}

std::vector<float> Frames::seeds(std::uint32_t frame) const {
    const Buffer& buffer = slots_[frame % in_flight].seeds;
    const std::size_t count = 4 * static_cast<std::size_t>(options_.seeds);
    return numbers<float>(download(device_, buffer.get(), count * sizeof(float)), 0, count);
}

Results Frames::results(std::uint32_t frame, std::size_t plan) const {
    const Cells& cells = slots_[frame % in_flight].cells[plan];
    const votess::vulkan::BufferSizes& sizes = plans_[plan].sizes();
    const std::vector<std::byte> bytes = download(device_, cells.results.get(), cells.results.bytes());
    const std::size_t count = options_.seeds;
    return {numbers<votess::vulkan::Header>(bytes, cells.ranges.header.offset, 1).front(),
            numbers<votess::vulkan::Cell>(bytes, cells.ranges.cells.offset, count),
            numbers<std::int32_t>(bytes, cells.ranges.indices.offset, sizes.indices / sizeof(std::int32_t)),
            numbers<float>(bytes, cells.ranges.geometry.offset, sizes.geometry > 0 ? 4 * count : 0)};
}

}  // namespace host
