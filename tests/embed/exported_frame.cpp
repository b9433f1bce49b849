// The half of the example cuda_frames that needs no CUDA. Another Vulkan device imports the exported memory and writes
// the seeds there. The rows that it reads must equal the CPU's. The host sets the values of the semaphore that CUDA
// would. Returns 0, 1 on a failure, 77 without a device that exports memory.
#include "../../bindings/examples/cuda_frames/exported_frame.hpp"

#include <unistd.h>

#include <cstdio>
#include <random>
#include <span>

namespace {

using vk::MemoryPropertyFlagBits::eHostCoherent, vk::MemoryPropertyFlagBits::eHostVisible;
constexpr auto descriptor_type = vk::ExternalMemoryHandleTypeFlagBits::eOpaqueFd;
constexpr vk::BufferUsageFlags usage = vk::BufferUsageFlagBits::eTransferSrc | vk::BufferUsageFlagBits::eTransferDst;

// A device of another program, with the exported buffer.
class Importer {
public:
    explicit Importer(const ExportedFrame& frame) : size_(frame.places().end) {
        const vk::ApplicationInfo application{.apiVersion = VK_API_VERSION_1_3};
        instance_ = vk::createInstanceUnique({.pApplicationInfo = &application});
        for (const vk::PhysicalDevice device : instance_->enumeratePhysicalDevices())
            if (std::ranges::equal(
                    device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceIDProperties>()
                        .get<vk::PhysicalDeviceIDProperties>()
                        .deviceUUID,
                    frame.uuid()))
                physical_ = device;
        const float priority = 1;
        const vk::DeviceQueueCreateInfo queue = vk::DeviceQueueCreateInfo{}.setQueuePriorities(priority);
        const char* const extension = VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME;
        device_ = physical_.createDeviceUnique(
            vk::DeviceCreateInfo{}.setQueueCreateInfos(queue).setPEnabledExtensionNames(extension));
        pool_ = device_->createCommandPoolUnique({});

        const vk::ExternalMemoryBufferCreateInfo external{.handleTypes = descriptor_type};
        constexpr auto same = vk::BufferUsageFlags(votess::vulkan::buffer_usage);
        shared_ = device_->createBufferUnique({.pNext = &external, .size = size_, .usage = same});
        const vk::MemoryDedicatedAllocateInfo dedicated{.buffer = *shared_};
        const vk::ImportMemoryFdInfoKHR import{
            .pNext = &dedicated, .handleType = descriptor_type, .fd = frame.memory_descriptor()};
        memory_ = device_->allocateMemoryUnique(
            {.pNext = &import, .allocationSize = frame.memory_size(), .memoryTypeIndex = frame.memory_type()});
        device_->bindBufferMemory(*shared_, *memory_, 0);
        make_staging();
    }

    // Copies bytes to the start of the imported buffer.
    void write(std::span<const std::byte> bytes) {
        std::ranges::copy(bytes, mapped_);
        copy(*staging_, *shared_, bytes.size());
    }
    // Returns all of the imported buffer.
    [[nodiscard]] std::span<const std::byte> read() {
        std::fill_n(mapped_, size_, std::byte{0xff});
        copy(*shared_, *staging_, size_);
        return {mapped_, size_};
    }

private:
    void make_staging() {
        staging_ = device_->createBufferUnique({.size = size_, .usage = usage});
        const vk::MemoryRequirements needs = device_->getBufferMemoryRequirements(*staging_);
        const vk::PhysicalDeviceMemoryProperties types = physical_.getMemoryProperties();
        std::uint32_t type = 0;
        while ((needs.memoryTypeBits >> type & 1) == 0 ||
               (types.memoryTypes[type].propertyFlags & (eHostVisible | eHostCoherent)) !=
                   (eHostVisible | eHostCoherent))
            ++type;
        staged_ = device_->allocateMemoryUnique({.allocationSize = needs.size, .memoryTypeIndex = type});
        device_->bindBufferMemory(*staging_, *staged_, 0);
        mapped_ = static_cast<std::byte*>(device_->mapMemory(*staged_, 0, VK_WHOLE_SIZE));
    }

    void copy(vk::Buffer from, vk::Buffer to, vk::DeviceSize bytes) {
        const auto commands =
            std::move(device_->allocateCommandBuffersUnique({.commandPool = *pool_, .commandBufferCount = 1}).front());
        commands->begin(vk::CommandBufferBeginInfo{});
        commands->copyBuffer(from, to, vk::BufferCopy{.size = bytes});
        commands->end();
        const vk::Queue queue = device_->getQueue(0, 0);
        queue.submit(vk::SubmitInfo{}.setCommandBuffers(*commands));
        queue.waitIdle();
    }

    vk::DeviceSize size_;
    vk::UniqueInstance instance_;
    vk::PhysicalDevice physical_;
    vk::UniqueDevice device_;
    vk::UniqueCommandPool pool_;
    vk::UniqueDeviceMemory memory_, staged_;
    vk::UniqueBuffer shared_, staging_;
    std::byte* mapped_ = nullptr;
};

// Whether any device exports memory.
bool can_export() {
    const vk::UniqueInstance instance = vk::createInstanceUnique({});
    for (const vk::PhysicalDevice device : instance->enumeratePhysicalDevices())
        for (const vk::ExtensionProperties& known : device.enumerateDeviceExtensionProperties())
            if (std::strcmp(known.extensionName, VK_KHR_EXTERNAL_MEMORY_FD_EXTENSION_NAME) == 0) return true;
    return false;
}

// Returns the number of certified cells, whose rows must equal those of the CPU.
std::uint32_t compare(std::span<const std::byte> buffer, const ExportedFrame::Places& places,
                      std::span<const float> seeds, const votess::Box& box) {
    std::vector<double> points;
    for (std::size_t i = 0; i < seeds.size(); i += 4)
        points.insert(points.end(), {seeds[i], seeds[i + 1], seeds[i + 2]});
    votess::Options options;
    options.box = box;
    const votess::Tessellation expected = votess::tessellate(points, options);

    votess::vulkan::Header header;
    std::memcpy(&header, buffer.data() + places.header, sizeof header);
    std::vector<votess::vulkan::Cell> cells(seeds.size() / 4);
    std::memcpy(cells.data(), buffer.data() + places.cells, cells.size() * sizeof cells[0]);
    std::vector<float> geometry(seeds.size());
    std::memcpy(geometry.data(), buffer.data() + places.geometry, geometry.size() * sizeof geometry[0]);
    std::vector<std::int32_t> indices(header.entries);
    std::memcpy(indices.data(), buffer.data() + places.indices, indices.size() * sizeof indices[0]);
    std::uint32_t certified = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i].status != static_cast<std::uint32_t>(votess::CellStatus::certified)) continue;
        ++certified;
        const auto row = std::span(indices).subspan(cells[i].row_begin, cells[i].row_length);
        if (!std::ranges::equal(row, expected.neighbors(i))) throw std::runtime_error("a row differs from the CPU's");
        const double volume = expected.volumes()[i];
        if (std::abs(static_cast<double>(geometry[4 * i + 3]) - volume) > 1e-5 * volume)
            throw std::runtime_error("a volume differs from the CPU's");
    }
    if (certified != header.certified) throw std::runtime_error("the header does not count the cells");
    return certified;
}

void report_semaphore(const ExportedFrame& frame) {
    try {
        close(frame.semaphore_descriptor());
        std::printf("the semaphore is exported\n");
    } catch (const std::runtime_error& error) {
        std::printf("%s\n", error.what());  // lavapipe
    }
}

// Waits until the frame's semaphore has a value. Returns false after some nanoseconds.
bool reaches(const ExportedFrame& frame, std::uint64_t value, std::uint64_t nanoseconds) {
    const vk::Semaphore semaphore = frame.semaphore();
    return frame.device().waitSemaphores(vk::SemaphoreWaitInfo{}.setSemaphores(semaphore).setValues(value),
                                         nanoseconds) == vk::Result::eSuccess;
}

int run() {
    if (!can_export()) {
        std::printf("no Vulkan device that exports memory\n");
        return 77;
    }
    constexpr std::uint32_t count = 2000;
    const votess::Box box{{0, 0, 0}, {1, 1, 1}};
    const ExportedFrame frame(count, box, {});
    report_semaphore(frame);
    Importer importer(frame);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::vector<float> seeds(std::size_t{4} * count);
    for (std::uint64_t step = 0; step < 2; ++step) {
        for (float& x : seeds) x = uniform(random);
        const std::uint64_t written = 2 * step + 1, done = 2 * step + 2;
        frame.submit(written, done);
        if (reaches(frame, done, 300'000'000)) throw std::runtime_error("the frame did not wait for the seeds");
        importer.write(std::as_bytes(std::span(seeds)));
        frame.device().signalSemaphore({.semaphore = frame.semaphore(), .value = written});
        if (!reaches(frame, done, 60'000'000'000)) throw std::runtime_error("the frame did not signal");
        const std::uint32_t certified = compare(importer.read(), frame.places(), seeds, box);
        std::printf("%u of %u rows in imported memory equal those of the CPU\n", certified, count);
        if (certified < 0.9 * count) return 1;
    }
    return 0;
}

}  // namespace

int main() {
    try {
        return run();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "exported_frame: %s\n", error.what());
        return 1;
    }
}
