// The Vulkan layer when something is wrong: failing calls, misuse, no driver, damaged cache files.
#include <doctest/doctest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "support/gpu/vulkan.hpp"

using namespace votess::gpu::vulkan;
using test::Environment;
using test::error_of;
using test::Gpu;
using test::scale_pass;
using test::ScalePush;
using votess::ErrorCode;
namespace fs = std::filesystem;

// Of the leak sanitizer; null in builds without it.
extern "C" __attribute__((weak)) void __lsan_disable();
extern "C" __attribute__((weak)) void __lsan_enable();

namespace {

// Synchronization validation itself leaks (1.3.239), from code that is unmapped when the leaks are listed: no
// suppression can name it.
struct LeaksIgnored {
    LeaksIgnored() {
        if (__lsan_disable) __lsan_disable();
    }
    ~LeaksIgnored() {
        if (__lsan_enable) __lsan_enable();
    }
};

// A function of Vulkan that only fails.
template <VkResult result, class... Arguments>
VKAPI_ATTR VkResult VKAPI_CALL failing(Arguments...) {
    return result;
}
template <VkResult result, class... Arguments>
void fail(VkResult(VKAPI_PTR*& entry)(Arguments...)) {
    entry = failing<result, Arguments...>;
}

// A driver's vkGetPipelineCacheData() with so many bytes.
template <std::size_t bytes>
VKAPI_ATTR VkResult VKAPI_CALL data_of_size(VkDevice, VkPipelineCache, std::size_t* size, void* data) {
    if (data != nullptr) std::memset(data, 1, bytes);
    *size = bytes;
    return VK_SUCCESS;
}

// Returns the bytes that the driver writes, which may be fewer than it says first.
std::size_t bytes_of_driver(const Gpu& gpu) {
    const auto get = [&](std::size_t& size, void* data) {
        return gpu.original.vkGetPipelineCacheData(gpu.device->handle(), gpu.device->pipeline_cache().handle(), &size,
                                                   data);
    };
    std::size_t size = 0;
    CHECK(get(size, nullptr) == VK_SUCCESS);
    std::vector<std::byte> data(size);
    CHECK(get(size, data.data()) == VK_SUCCESS);
    return size;
}

// Does all that an engine does, on little data.
void everything(Device& device) {
    Memory memory(device);
    Buffer source = memory.buffer(400, MemoryKind::upload, "source");
    Buffer target = memory.buffer(400, MemoryKind::device, "target");
    const Pass pass = scale_pass(device, 32);
    Commands commands(device, 4);
    commands.begin();
    commands.timestamp();
    commands.fill(target, 0, 400, 0);
    commands.barrier();
    const BufferBinding buffers[] = {{2, &source}, {5, &target}};
    commands.dispatch(pass, buffers, push_bytes(ScalePush{100, 1}), 100);
    commands.barrier_to_host();
    commands.end();
    commands.submit();
    commands.wait();
}

// A temporary folder.
struct TemporaryFolder {
    fs::path path;

    TemporaryFolder() {
        std::string name = (fs::temp_directory_path() / "votess-test-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()));
        path = name;
    }
    ~TemporaryFolder() { fs::remove_all(path); }
};

std::string bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

void replace(const fs::path& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

// Machines with a GPU may lack it. The tests of the whole suite run under it, and need it.
bool has_validation_layer() {
    return !error_of([] { (void)Instance::create({.validation = true}); });
}

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("vulkan: a failing call is the right error and leaves nothing behind") {
        using Break = void (*)(VolkDeviceTable&);
        const Break no_memory[] = {
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkAllocateMemory); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_TOO_MANY_OBJECTS>(t.vkAllocateMemory); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_MEMORY_MAP_FAILED>(t.vkMapMemory); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkCreateBuffer); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkBindBufferMemory); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateDescriptorSetLayout); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreatePipelineLayout); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateShaderModule); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkCreateComputePipelines); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateCommandPool); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkAllocateCommandBuffers); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateFence); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateQueryPool); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkBeginCommandBuffer); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_HOST_MEMORY>(t.vkCreateDescriptorPool); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_POOL_MEMORY>(t.vkAllocateDescriptorSets); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkEndCommandBuffer); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_OUT_OF_DEVICE_MEMORY>(t.vkQueueSubmit); },
        };
        const Break lost[] = {
            [](VolkDeviceTable& t) { fail<VK_ERROR_DEVICE_LOST>(t.vkAllocateMemory); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_DEVICE_LOST>(t.vkQueueSubmit); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_DEVICE_LOST>(t.vkWaitForFences); },
        };
        Gpu gpu;
        const bool timestamps = gpu.adapter.timestamp_bits > 0;
        const auto check_all = [&](std::span<const Break> breaks, ErrorCode code, const char* words) {
            for (std::size_t i = 0; i < breaks.size(); ++i) {
                INFO("case " << i);
                breaks[i](gpu.device->table());
                if (!timestamps && gpu.original.vkCreateQueryPool != gpu.device->table().vkCreateQueryPool) continue;
                std::string message;
                CHECK(error_of([&] { everything(*gpu.device); }, &message) == code);
                CHECK_MESSAGE(message.find(words) != std::string::npos, message);
                gpu.device->table() = gpu.original;
            }
        };
        check_all(no_memory, ErrorCode::out_of_memory, "memory");
        check_all(lost, ErrorCode::device_lost, "the device was lost in vk");
        const Break refused[] = {
            [](VolkDeviceTable& t) { fail<VK_ERROR_UNKNOWN>(t.vkCreateComputePipelines); },
            [](VolkDeviceTable& t) { fail<VK_ERROR_INVALID_SHADER_NV>(t.vkCreateShaderModule); },
        };
        check_all(refused, ErrorCode::unsupported, "the driver refuses, VK_ERROR_");
        const Break other[] = {[](VolkDeviceTable& t) { fail<VK_ERROR_FRAGMENTED_POOL>(t.vkEndCommandBuffer); }};
        check_all(other, ErrorCode::internal, "VK_ERROR_FRAGMENTED_POOL in vkEndCommandBuffer");
        everything(*gpu.device);  // the device still works
    }

    TEST_CASE("vulkan: a large block that cannot be had becomes a small one") {
        Gpu gpu;
        static PFN_vkAllocateMemory allocate;
        allocate = gpu.original.vkAllocateMemory;
        gpu.device->table().vkAllocateMemory = [](VkDevice device, const VkMemoryAllocateInfo* info,
                                                  const VkAllocationCallbacks* callbacks, VkDeviceMemory* memory) {
            return info->allocationSize > 100000 ? VK_ERROR_OUT_OF_DEVICE_MEMORY
                                                 : allocate(device, info, callbacks, memory);
        };
        Memory memory(*gpu.device);
        const Buffer buffer = memory.buffer(5000, MemoryKind::device);
        CHECK(memory.block_bytes() < 10000);
        CHECK(error_of([&] { (void)memory.buffer(200000, MemoryKind::device); }) == ErrorCode::out_of_memory);
    }

    TEST_CASE("vulkan: our own mistakes are named") {
        Gpu gpu;
        Memory memory(*gpu.device);
        const Buffer small = memory.buffer(64, MemoryKind::device);
        const Pass pass = scale_pass(*gpu.device, 32);
        Commands commands(*gpu.device);
        const ScalePush push{1, 1};
        const auto said = [&](auto&& call) {
            std::string message;
            CHECK(error_of(call, &message) == ErrorCode::internal);
            return message;
        };
        CHECK(said([&] { commands.submit(); }) == "Commands::submit at the wrong time");
        CHECK(said([&] { commands.barrier(); }) == "Commands::barrier at the wrong time");
        commands.begin();
        const BufferBinding one[] = {{2, &small}};
        CHECK(said([&] { commands.dispatch(pass, one, push_bytes(push), 1); }) ==
              "binding 5 of the pass test_scale has no buffer");
        const BufferBinding far[] = {{2, &small}, {5, &small, 0, 65}};
        CHECK(said([&] { commands.dispatch(pass, far, push_bytes(push), 1); }) ==
              "binding 5 of the pass test_scale goes beyond the end of its buffer");
        CHECK(said([&] { commands.dispatch(pass, far, {}, 1); }).find("takes 8 bytes") != std::string::npos);
        said([&] { commands.copy(small, 32, small, 0, 33); });
        said([&] { commands.fill(small, 0, 6, 0); });
        said([&] { commands.dispatch_indirect(pass, far, push_bytes(push), small, 56); });
        commands.end();
        CHECK(error_of([&] { (void)scale_pass(*gpu.device, 1u << 30); }) == ErrorCode::unsupported);
    }

    TEST_CASE("vulkan: validation hears of misuse") {
        if (!has_validation_layer()) return;
        const auto instance = Instance::create({.validation = true});
        const auto device = Device::create(instance, Gpu::first(*instance));
        CHECK(instance->take_messages().empty());
        VkBufferCreateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
        info.size = 16;
        info.usage = 0;  // invalid
        VkBuffer buffer = VK_NULL_HANDLE;
        device->table().vkCreateBuffer(device->handle(), &info, nullptr, &buffer);
        device->table().vkDestroyBuffer(device->handle(), buffer, nullptr);
        const auto messages = instance->take_messages();
        REQUIRE(messages.size() == 1);
        CHECK(messages[0].rfind("error: ", 0) == 0);
        // Its last part differs: the rule has another name with VkBufferUsageFlags2CreateInfo.
        CHECK_MESSAGE(messages[0].find("VUID-VkBufferCreateInfo-") != std::string::npos, messages[0]);
        CHECK(instance->take_messages().empty());
    }

    TEST_CASE("vulkan: a forgotten barrier is found") {
        if (!has_validation_layer()) return;
        const LeaksIgnored ignored;
        const auto instance = Instance::create({.validation = true, .synchronization = true});
        const auto device = Device::create(instance, Gpu::first(*instance));
        Memory memory(*device);
        const Buffer buffer = memory.buffer(64, MemoryKind::device);
        Commands commands(*device);
        commands.begin();
        commands.fill(buffer, 0, 64, 0);
        commands.fill(buffer, 0, 64, 1);
        commands.end();
        const auto messages = instance->take_messages();
        REQUIRE(!messages.empty());
        CHECK_MESSAGE(messages[0].find("SYNC-HAZARD-WRITE") != std::string::npos, messages[0]);
    }

    TEST_CASE("vulkan: without a driver there are no adapters") {
        const Environment drivers("VK_DRIVER_FILES", "/nonexistent");
        const Environment old_name("VK_ICD_FILENAMES", nullptr);
        const Environment more("VK_ADD_DRIVER_FILES", nullptr);
        for (const bool validation : {false, true}) {
            if (validation && !has_validation_layer()) continue;
            const auto instance = Instance::create({.validation = validation, .synchronization = false});
            CHECK(instance->adapters().empty());
        }
    }

    TEST_CASE("vulkan: where the cache is") {
        const Environment own("VOTESS_CACHE_DIR", "/a");
        const Environment xdg("XDG_CACHE_HOME", "/b");
        const Environment home("HOME", "/c");
        CHECK(cache_directory() == "/a");
        {
            const Environment off("VOTESS_CACHE_DIR", "");
            CHECK(cache_directory().empty());
            CHECK(cache_file(Adapter{}).empty());
        }
        const Environment unset("VOTESS_CACHE_DIR", nullptr);
        CHECK(cache_directory() == "/b/votess");
        {
            const Environment relative("XDG_CACHE_HOME", "b");
            CHECK(cache_directory() == "/c/.cache/votess");
            const Environment homeless("HOME", nullptr);
            CHECK(cache_directory().empty());
        }
    }

    TEST_CASE("vulkan: the pipeline cache survives, and damage to its file too") {
        const TemporaryFolder folder;
        const Environment own("VOTESS_CACHE_DIR", (folder.path / "new" / "cache").c_str());
        fs::path file;
        {
            Gpu gpu;
            file = cache_file(gpu.adapter);
            CHECK(gpu.device->pipeline_cache().loaded_bytes() == 0);
            everything(*gpu.device);
            if (bytes_of_driver(gpu) < sizeof(VkPipelineCacheHeaderVersionOne)) return;
        }
        REQUIRE(fs::is_regular_file(file));
        CHECK(std::distance(fs::directory_iterator(file.parent_path()), {}) == 1);
        const std::string good = bytes_of(file);
        std::string foreign = good, damaged = good;
        foreign[24 + 8] ^= 1;  // the vendor, after a header of 24 bytes and two words
        damaged.back() ^= 1;
        const std::string bad[] = {"",      "x",    good.substr(0, 24), good.substr(0, good.size() - 1), good + "x",
                                   foreign, damaged};
        for (const std::string& bytes : bad) {
            replace(file, bytes);
            {
                Gpu gpu;
                CHECK(read_cache(file, gpu.adapter).empty());
                CHECK(gpu.device->pipeline_cache().loaded_bytes() == 0);
                everything(*gpu.device);
            }
            Gpu gpu;  // and was replaced
            CHECK(gpu.device->pipeline_cache().loaded_bytes() == fs::file_size(file) - 24);
            Adapter other = gpu.adapter;
            other.device_id ^= 1;
            CHECK(read_cache(file, other).empty());
            CHECK(cache_file(other) != file);
            other = gpu.adapter;
            other.driver_version ^= 1;
            CHECK(cache_file(other) != file);
        }
    }

    TEST_CASE("vulkan: a pipeline cache without a whole header is not written") {
        const TemporaryFolder folder;
        const Environment own("VOTESS_CACHE_DIR", folder.path.c_str());
        const auto write = [](PFN_vkGetPipelineCacheData get) {
            Gpu gpu;
            const PFN_vkGetPipelineCacheData original = gpu.device->table().vkGetPipelineCacheData;
            gpu.device->table().vkGetPipelineCacheData = get;
            { const PipelineCache cache(gpu.device->table(), gpu.device->handle(), gpu.adapter); }
            const bool written = fs::exists(cache_file(gpu.adapter));
            fs::remove(cache_file(gpu.adapter));
            gpu.device->table().vkGetPipelineCacheData = original;
            return written;
        };
        CHECK(!write(data_of_size<20>));
        CHECK(write(data_of_size<32>));
    }

    TEST_CASE("vulkan: a cache that cannot be written does no harm") {
        for (const char* where : {"/proc/nowhere", "/dev/null", "/dev/null/x"}) {
            const Environment own("VOTESS_CACHE_DIR", where);
            Gpu gpu;
            everything(*gpu.device);
            const std::byte data[4]{};
            CHECK(!write_cache(cache_file(gpu.adapter), data));
        }
    }
}
