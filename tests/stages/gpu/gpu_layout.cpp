// The structs of shaders/shared/layout.h have the same layout in GLSL and C++.
#include <doctest/doctest.h>

#include <cstring>

#include "shared/layout.h"
#include "support/gpu/vulkan.hpp"

using namespace votess::gpu;
using namespace votess::gpu::vulkan;
namespace shaders = votess::gpu::shaders;
using Words = std::vector<std::uint32_t>;

namespace {

// Distinct words. None is a NaN or a subnormal number, which a driver might change.
std::uint32_t word(std::size_t i) {
    return 0x3f800000u + 0x1111u * static_cast<std::uint32_t>(i + 1);
}

template <class T>
T filled() {
    static_assert(sizeof(T) % 4 == 0 && std::is_trivially_copyable_v<T>);
    Words words(sizeof(T) / 4);
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = word(i);
    T value;
    std::memcpy(&value, words.data(), sizeof value);
    return value;
}

// The fields' words in the order of the arguments.
template <class... Fields>
Words words_of(const Fields&... fields) {
    Words words;
    const auto add = [&](const auto& field) {
        static_assert(sizeof field % 4 == 0);
        const std::size_t at = words.size();
        words.resize(at + sizeof field / 4);
        std::memcpy(words.data() + at, &field, sizeof field);
    };
    (add(fields), ...);
    return words;
}

class Reader {
public:
    // Returns the words that the shader read from the push constants or from the buffer at binding 0.
    Words run(std::span<const std::uint32_t> spirv, std::span<const std::byte> push,
              std::span<const std::byte> buffer = {}) {
        constexpr VkDeviceSize bytes = 400;
        Memory memory(*gpu_.device);
        const Buffer source = memory.buffer(bytes, MemoryKind::upload),
                     target = memory.buffer(bytes, MemoryKind::download);
        std::copy(buffer.begin(), buffer.end(), source.mapped().begin());
        source.flush();
        const Pass pass(*gpu_.device, {.name = "test_layout",
                                       .spirv = spirv,
                                       .push_bytes = static_cast<std::uint32_t>(push.size()),
                                       .local_size = 1});
        Commands commands(*gpu_.device);
        commands.begin();
        commands.fill(target, 0, bytes, 0);
        commands.barrier();
        const BufferBinding buffers[] = {{0, &source}, {1, &target}};
        commands.dispatch(pass, buffers, push, 1);
        commands.barrier_to_host();
        commands.end();
        commands.submit();
        commands.wait();
        target.invalidate();
        const auto words = target.as<std::uint32_t>();
        REQUIRE(words[0] < words.size());
        return {words.begin() + 1, words.begin() + 1 + words[0]};
    }
    template <class T>
    Words push(std::span<const std::uint32_t> spirv, const T& value) {
        return run(spirv, push_bytes(value));
    }
    Words buffer(std::span<const std::uint32_t> spirv, std::span<const std::byte> bytes) {
        const std::uint32_t unused = 0;
        return run(spirv, push_bytes(unused), bytes);
    }

private:
    test::Gpu gpu_;
};

}  // namespace

TEST_SUITE("stages") {
    TEST_CASE("gpu layout: push constants") {
        Reader reader;
        const auto check = [&](const char* name, std::span<const std::uint32_t> spirv, const auto& value,
                               const Words& expected) {
            CAPTURE(name);
            CHECK(sizeof value == 4 * expected.size());  // all fields, no padding
            CHECK(sizeof value <= 128);                  // the limit of every device
            CHECK(reader.push(spirv, value) == expected);
        };
        const auto upload = filled<UploadPush>();
        check("UploadPush", shaders::test_layout_upload, upload,
              words_of(upload.origin, upload.first, upload.count, upload.shift, upload.format, upload.lower,
                       upload.upper, upload.stride, upload.check, upload.begin, upload.total));
        const auto images = filled<ImagesPush>();
        check("ImagesPush", shaders::test_layout_images, images,
              words_of(images.lower, images.side, images.extent, images.periodic, images.count, images.total));
        const auto sort = filled<SortPush>();
        check("SortPush", shaders::test_layout_sort, sort,
              words_of(sort.count, sort.tiles, sort.shift, sort.high_word));
        const auto key = filled<KeyPush>();
        check("KeyPush", shaders::test_layout_key, key, words_of(key.total, key.bits, key.blocks_per_unit));
        const auto scan = filled<ScanPush>();
        check("ScanPush", shaders::test_layout_scan, scan, words_of(scan.count));
        const auto boxes = filled<BoxesPush>();
        check("BoxesPush", shaders::test_layout_boxes, boxes,
              words_of(boxes.seed_count, boxes.level, boxes.first, boxes.count, boxes.below_first, boxes.below_count));
        const auto reach = filled<ReachPush>();
        check("ReachPush", shaders::test_layout_reach, reach,
              words_of(reach.lower, reach.upper, reach.side, reach.bounded, reach.periodic, reach.seed_count,
                       reach.own_count, reach.level_count, reach.node_count, reach.max_visits));
        const auto knn = filled<KnnPush>();
        check("KnnPush", shaders::test_layout_knn, knn,
              words_of(knn.lower, knn.upper, knn.bounded, knn.first_cell, knn.cell_count, knn.seed_count, knn.own_count,
                       knn.level_count, knn.max_visits, knn.keeps, knn.level_first));
        const auto clip = filled<ClipPush>();
        check("ClipPush", shaders::test_layout_clip, clip,
              words_of(clip.extent, clip.first_cell, clip.cell_count, clip.seed_count, clip.own_count, clip.row_stride,
                       clip.walls, clip.neighbors, clip.volume_tolerance, clip.max_visits, clip.bounded, clip.keeps,
                       clip.kept_reach, clip.level_count, clip.level_first));
        const auto cells = filled<CellsPush>();
        check("CellsPush", shaders::test_layout_cells, cells,
              words_of(cells.extent, cells.lower, cells.upper, cells.bounded, cells.first_cell, cells.cell_count,
                       cells.seed_count, cells.own_count, cells.level_count, cells.max_visits, cells.row_stride,
                       cells.walls, cells.neighbors, cells.volume_tolerance, cells.keeps));
        const auto kept = filled<KeptPush>();
        check("KeptPush", shaders::test_layout_kept, kept,
              words_of(kept.cell_count, kept.own_count, kept.image_count, kept.keeps, kept.capacity, kept.max_pending));
        const auto cover = filled<CoverPush>();
        check("CoverPush", shaders::test_layout_cover, cover,
              words_of(cover.extent, cover.vectors, cover.periodic, cover.bounded, cover.cell_count, cover.seed_count,
                       cover.own_count, cover.keeps, cover.root));
        const auto todo = filled<TodoPush>();
        check("TodoPush", shaders::test_layout_todo, todo,
              words_of(todo.cell_count, todo.max_of_tile, todo.group, todo.places, todo.keeps));
        const auto rows = filled<RowsPush>();
        check("RowsPush", shaders::test_layout_rows, rows,
              words_of(rows.first_cell, rows.cell_count, rows.row_stride, rows.second_row_stride, rows.second_first,
                       rows.capacity, rows.window, rows.window_bits, rows.named_from, rows.shifts, rows.shift));
        const auto gather = filled<GatherPush>();
        check("GatherPush", shaders::test_layout_gather, gather,
              words_of(gather.first_cell, gather.cell_count, gather.first_entry, gather.entry_count, gather.areas,
                       gather.shifts));
    }

    TEST_CASE("gpu layout: of recorded frames") {
        Reader reader;
        const auto push = filled<FramePush>();
        const Words push_words = words_of(push.first_cell, push.cell_count, push.capacity, push.neighbors,
                                          push.geometry, push.shift, push.seed_count, push.own_count, push.keeps);
        CHECK(sizeof push == 4 * push_words.size());
        CHECK(reader.push(shaders::test_layout_frame, push) == push_words);
        const auto header = filled<FrameHeader>();
        const Words header_words =
            words_of(header.seeds, header.certified, header.unresolved, header.duplicates, header.outside,
                     header.entries, header.faces, header.images, header.empty, header.kept);
        CHECK(sizeof header == 4 * header_words.size());
        CHECK(reader.buffer(shaders::test_layout_header, push_bytes(header)) == header_words);
        const auto cell = filled<FrameCell>();
        const Words cell_words = words_of(cell.status, cell.row_begin, cell.row_length, cell.faces);
        CHECK(sizeof cell == 4 * cell_words.size());
        CHECK(reader.buffer(shaders::test_layout_cell, push_bytes(cell)) == cell_words);
    }

    TEST_CASE("gpu layout: states") {
        Reader reader;
        const auto run = filled<RunState>();
        const Words run_words = words_of(run.lossy, run.suspects, run.duplicates, run.incomplete, run.weight_exponent,
                                         run.lossy_weights, run.heaviest, run.present, run.unused);
        CHECK(sizeof run == 4 * run_words.size());
        CHECK(reader.buffer(shaders::test_layout_run, push_bytes(run)) == run_words);
        const auto chunk = filled<ChunkState>();
        const Words chunk_words =
            words_of(chunk.todo_count, chunk.groups_x, chunk.groups_y, chunk.groups_z, chunk.subgroups_x,
                     chunk.subgroups_y, chunk.subgroups_z, chunk.left_count, chunk.row_base, chunk.kept_pending,
                     chunk.kept_over, chunk.kept_over_cell, chunk.kept_failed, chunk.unknown_count, chunk.kept_point,
                     chunk.unknown, chunk.unused);
        CHECK(sizeof chunk == 4 * chunk_words.size());
        CHECK(reader.buffer(shaders::test_layout_chunk, push_bytes(chunk)) == chunk_words);
        const auto wall = filled<WallPlane>();
        const Words wall_words = words_of(wall.normal, wall.offset, wall.rough);
        CHECK(sizeof wall == 4 * wall_words.size());
        CHECK(reader.buffer(shaders::test_layout_wall, push_bytes(wall)) == wall_words);
        // They lie behind the run state.
        static_assert(sizeof(RunState) % 8 == 0 && sizeof(WallPlane) % 8 == 0);
        // The words that an indirect dispatch reads.
        static_assert(offsetof(ChunkState, groups_y) == offsetof(ChunkState, groups_x) + 4);
        static_assert(offsetof(ChunkState, groups_z) == offsetof(ChunkState, groups_x) + 8);
        static_assert(offsetof(ChunkState, subgroups_y) == offsetof(ChunkState, subgroups_x) + 4);
        static_assert(offsetof(ChunkState, subgroups_z) == offsetof(ChunkState, subgroups_x) + 8);
    }
}
