#include "gpu/vulkan/pipeline_cache.hpp"

#include <array>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include "core/system.hpp"

namespace votess::gpu::vulkan {
namespace {

namespace fs = std::filesystem;

// Drivers check the device, but some crash on a truncated file; so a file has a header of our own.
struct FileHeader {
    std::array<char, 8> magic{'v', 'o', 't', 'e', 's', 's', 'p', '1'};
    std::uint64_t bytes = 0;
    std::uint64_t hash = 0;
};

// A larger file is not ours and is not read.
constexpr std::uint64_t max_bytes = std::uint64_t{256} << 20;

std::uint64_t fnv1a(std::span<const std::byte> data) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const std::byte b : data) hash = (hash ^ std::to_integer<std::uint64_t>(b)) * 0x100000001b3u;
    return hash;
}

std::string hex(std::uint64_t value, int digits) {
    std::string text(static_cast<std::size_t>(digits), '0');
    for (auto it = text.rbegin(); it != text.rend(); ++it, value >>= 4) *it = "0123456789abcdef"[value & 15];
    return text;
}

// Returns an empty path for a variable that is unset or relative: a relative one would depend on the current directory.
fs::path directory_from(const char* variable) {
    const char* value = std::getenv(variable);
    const fs::path path = value ? value : "";
    return path.is_absolute() ? path : fs::path();
}

bool belongs_to(std::span<const std::byte> data, const Adapter& adapter) {
    VkPipelineCacheHeaderVersionOne header{};
    if (data.size() < sizeof header) return false;
    std::memcpy(&header, data.data(), sizeof header);
    return header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE && header.headerSize >= sizeof header &&
           header.headerSize <= data.size() && header.vendorID == adapter.vendor_id &&
           header.deviceID == adapter.device_id &&
           std::memcmp(header.pipelineCacheUUID, adapter.cache_uuid.data(), VK_UUID_SIZE) == 0;
}

}  // namespace

fs::path cache_directory() {
    if (const char* own = std::getenv("VOTESS_CACHE_DIR")) return own;
    if (const fs::path base = directory_from("XDG_CACHE_HOME"); !base.empty()) return base / "votess";
    if (const fs::path home = directory_from("HOME"); !home.empty()) return home / ".cache" / "votess";
    if (const fs::path windows = directory_from("LOCALAPPDATA"); !windows.empty()) return windows / "votess";
    return {};
}

fs::path cache_file(const Adapter& adapter) {
    const fs::path directory = cache_directory();
    if (directory.empty()) return {};
    std::string name = "pipelines-" + hex(adapter.vendor_id, 8) + "-" + hex(adapter.device_id, 8) + "-";
    for (const std::uint8_t byte : adapter.cache_uuid) name += hex(byte, 2);
    return directory / (name + "-" + hex(adapter.driver_version, 8) + ".bin");
}

std::vector<std::byte> read_cache(const fs::path& file, const Adapter& adapter) noexcept {
    try {
        std::error_code error;
        if (file.empty() || !fs::is_regular_file(file, error)) return {};
        std::ifstream in(file, std::ios::binary);
        FileHeader header;
        in.read(reinterpret_cast<char*>(&header), sizeof header);
        if (!in || header.magic != FileHeader{}.magic || header.bytes > max_bytes) return {};
        // The size is checked first: a damaged header must not reserve memory.
        if (fs::file_size(file, error) != sizeof header + header.bytes || error) return {};
        std::vector<std::byte> data(header.bytes);
        in.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()));
        if (!in || fnv1a(data) != header.hash || !belongs_to(data, adapter)) return {};
        return data;
    } catch (...) {
        return {};
    }
}

bool write_cache(const fs::path& file, std::span<const std::byte> data) noexcept {
    try {
        std::error_code error;
        fs::create_directories(file.parent_path(), error);
        // The process id makes the name unique among processes, the address of the data among devices.
        fs::path temporary = file;
        temporary += ".tmp" + std::to_string(system::process_id()) + "-" +
                     hex(reinterpret_cast<std::uintptr_t>(data.data()), 16);
        bool good = false;
        {
            std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
            FileHeader header;
            header.bytes = data.size();
            header.hash = fnv1a(data);
            out.write(reinterpret_cast<const char*>(&header), sizeof header);
            out.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
            out.close();
            good = out.good();
        }
        if (good) fs::rename(temporary, file, error);
        if (good && !error) return true;
        fs::remove(temporary, error);
    } catch (...) {
    }
    return false;
}

PipelineCache::PipelineCache(const VolkDeviceTable& table, VkDevice device, const Adapter& adapter)
    : table_(table), device_(device), file_(cache_file(adapter)) {
    const std::vector<std::byte> data = read_cache(file_, adapter);
    auto info = structure<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
    info.initialDataSize = data.size();
    info.pInitialData = data.data();
    if (table_.vkCreatePipelineCache(device_, &info, nullptr, &handle_) != VK_SUCCESS) {
        handle_ = VK_NULL_HANDLE;
        return;
    }
    loaded_bytes_ = data.size();
}

PipelineCache::~PipelineCache() {
    if (!handle_) return;
    save();
    table_.vkDestroyPipelineCache(device_, handle_, nullptr);
}

void PipelineCache::save() const noexcept {
    try {
        std::size_t size = 0;
        if (file_.empty() || table_.vkGetPipelineCacheData(device_, handle_, &size, nullptr) != VK_SUCCESS) return;
        if (size == loaded_bytes_) return;
        std::vector<std::byte> data(size);
        if (table_.vkGetPipelineCacheData(device_, handle_, &size, data.data()) != VK_SUCCESS) return;
        data.resize(size);
        // lavapipe (Mesa 26.2) returns 20 bytes, which read_cache() refuses.
        if (size >= sizeof(VkPipelineCacheHeaderVersionOne)) write_cache(file_, data);
    } catch (...) {
    }
}

}  // namespace votess::gpu::vulkan
