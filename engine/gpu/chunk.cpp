#include "gpu/chunk.hpp"

#include <algorithm>
#include <limits>
#include <optional>

namespace votess::gpu {

using vulkan::MemoryKind;

Chunk::Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings)
    : float64_(device.has_float64()), measure_(settings.measure), buffers_(memory), commands_(device, 4) {
    cells_.reserve(buffers_, cells, settings);
    const auto on_host = [&](VkDeviceSize bytes, const char* name) {
        return memory.buffer(bytes, MemoryKind::download, name);
    };
    info_host_ = on_host(cells_.slice(BINDING_INFO).size, "info, host");
    length_host_ = on_host(cells_.slice(BINDING_ROW_LENGTH).size, "row length, host");
    geometry_host_ = on_host(cells_.slice(BINDING_GEOMETRY).size, "geometry, host");
    state_host_ = on_host(sizeof(ChunkState), "chunk state, host");
    const VkDeviceSize entries = cells_.most_entries();
    rows_out_ = on_host(entries * 4, "rows out");
    areas_out_ = on_host(settings.areas ? entries * DeviceCells::number_bytes : 0, "areas out");
    constexpr VkDeviceSize countable = std::numeric_limits<std::uint32_t>::max();
    cells_.set_rows_out(rows_out_, areas_out_, static_cast<std::uint32_t>(std::min(entries, countable)));
}

void Chunk::start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, const Piece& piece) {
    piece_ = piece;
    cells_.set_job(seeds.on_device(), passes.settings, job, piece.first, piece.count);

    commands_.begin();
    std::optional<Commands::Label> label(std::in_place, commands_, "knn");
    const Slice state = cells_.slice(BINDING_CHUNK_STATE);
    commands_.fill(state, offsetof(ChunkState, row_base), 4, 0);
    stamps_[0] = commands_.timestamp();
    cells_.record_knn(commands_, passes);
    stamps_[1] = commands_.timestamp();
    label.emplace(commands_, "clip");
    cells_.record_clip(commands_, passes, piece.second_tier, piece.ties);
    stamps_[2] = commands_.timestamp();
    label.emplace(commands_, "download");
    if (job.neighbors) cells_.record_rows(commands_, passes);
    const auto copy = [&](std::uint32_t binding, const Buffer& to) {
        const Slice from = cells_.slice(binding);
        commands_.copy(from, 0, to, 0, from.size / cells_.capacity() * piece.count);
    };
    copy(BINDING_INFO, info_host_);
    copy(BINDING_ROW_LENGTH, length_host_);
    if (measure_) copy(BINDING_GEOMETRY, geometry_host_);
    commands_.copy(state, 0, state_host_, 0, sizeof(ChunkState));
    stamps_[3] = commands_.timestamp();
    commands_.barrier_to_host();
    label.reset();
    commands_.end();
    commands_.submit();
}

void Chunk::wait() {
    commands_.wait();
    for (const Buffer* buffer : {&info_host_, &length_host_, &geometry_host_, &state_host_, &rows_out_, &areas_out_})
        buffer->invalidate();
}

double Chunk::area(std::size_t entry) const {
    return number(areas_out_, entry);
}

double Chunk::geometry(std::uint32_t cell, std::uint32_t component) const {
    return number(geometry_host_, std::size_t{cell} * DeviceCells::geometry_components + component);
}

double Chunk::number(const Buffer& buffer, std::size_t i) const {
    if (float64_) return buffer.as<double>()[i];
    const auto halves = buffer.as<float>().subspan(2 * i, 2);
    return static_cast<double>(halves[0]) + static_cast<double>(halves[1]);
}

Chunk::Seconds Chunk::seconds() const {
    const auto between = [&](int from, int to) { return commands_.seconds(stamps_[from], stamps_[to]); };
    return {between(0, 1), between(1, 2), between(2, 3)};
}

}  // namespace votess::gpu
