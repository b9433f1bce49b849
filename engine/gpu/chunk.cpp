#include "gpu/chunk.hpp"

namespace votess::gpu {

using vulkan::MemoryKind;

Chunk::Chunk(vulkan::Device& device, vulkan::Memory& memory, std::uint32_t cells, const PassSettings& settings)
    : buffers_(memory), commands_(device, 4) {
    cells_.reserve(buffers_, cells, settings);
    info_host_ = memory.buffer(VkDeviceSize{4} * cells, MemoryKind::download, "info, host");
    state_host_ = memory.buffer(sizeof(ChunkState), MemoryKind::download, "chunk state, host");
}

void Chunk::start(const SeedStore& seeds, const Passes& passes, const ChunkJob& job, const Piece& piece,
                  const DeviceResults& results) {
    piece_ = piece;
    results.take_rows_of(cells_);
    cells_.set_job(seeds.on_device(), passes.settings, job, piece.first, piece.count);

    commands_.submit([&] {
        stamps_[0] = commands_.timestamp();
        cells_.record_knn(commands_, passes);
        stamps_[1] = commands_.timestamp();
        cells_.record_clip(commands_, passes, piece.second_tier, piece.ties);
        stamps_[2] = commands_.timestamp();
        const auto label = commands_.label("download");
        results.record_chunk(commands_, passes, cells_, job, piece.first, piece.count);
        commands_.copy(cells_.words_of(WORDS_INFO), 0, info_host_, 0, VkDeviceSize{4} * piece.count);
        commands_.copy(cells_.state(), 0, state_host_, 0, sizeof(ChunkState));
        stamps_[3] = commands_.timestamp();
        commands_.barrier_to_host();
    });
}

void Chunk::wait() {
    commands_.wait();
    info_host_.invalidate(info().size_bytes());
    state_host_.invalidate();
}

Chunk::Seconds Chunk::seconds() const {
    const auto between = [&](int from, int to) { return commands_.seconds(stamps_[from], stamps_[to]); };
    return {between(0, 1), between(1, 2), between(2, 3)};
}

}  // namespace votess::gpu
