// Compiled pipelines kept on disk between runs. No function here fails: without a cache pipelines compile again.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "gpu/vulkan/adapter.hpp"
#include "gpu/vulkan/api.hpp"

namespace votess::gpu::vulkan {

// Returns $VOTESS_CACHE_DIR, else $XDG_CACHE_HOME/votess, else $HOME/.cache/votess; empty = no cache. A
// VOTESS_CACHE_DIR that is set but empty means no cache.
[[nodiscard]] std::filesystem::path cache_directory();
// Returns the file for this device and driver; empty when there is no cache.
[[nodiscard]] std::filesystem::path cache_file(const Adapter& adapter);

// Returns the data of a file that write_cache() made for this device and driver; empty for any other file.
[[nodiscard]] std::vector<std::byte> read_cache(const std::filesystem::path& file, const Adapter& adapter) noexcept;
// Replaces the file in one step. Returns false and leaves no trace where that fails.
bool write_cache(const std::filesystem::path& file, std::span<const std::byte> data) noexcept;

// A VkPipelineCache that starts with the data of the file. Its destructor writes the data back when it has grown.
class PipelineCache {
public:
    PipelineCache(const VolkDeviceTable& table, VkDevice device, const Adapter& adapter);
    ~PipelineCache();
    PipelineCache(const PipelineCache&) = delete;
    PipelineCache& operator=(const PipelineCache&) = delete;

    [[nodiscard]] VkPipelineCache handle() const { return handle_; }
    [[nodiscard]] std::size_t loaded_bytes() const { return loaded_bytes_; }

private:
    void save() const noexcept;

    const VolkDeviceTable& table_;
    VkDevice device_;
    std::filesystem::path file_;
    VkPipelineCache handle_ = VK_NULL_HANDLE;
    std::size_t loaded_bytes_ = 0;
};

}  // namespace votess::gpu::vulkan
