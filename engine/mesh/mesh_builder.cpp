#include "mesh/mesh_builder.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/arithmetic.hpp"

namespace votess {
namespace {

constexpr std::size_t task_cells = 4096;
constexpr std::size_t lookahead = 8;  // cells whose records are fetched before they are needed
constexpr std::size_t min_segment = std::size_t{1} << 16, max_segment = std::size_t{32} << 20;

// task(block, begin, end)
template <class Task>
void for_cells(ThreadPool& pool, std::size_t count, Task task) {
    pool.run(ceil_div(count, task_cells), [&](std::size_t block, unsigned) {
        task(block, block * task_cells, std::min(count, (block + 1) * task_cells));
    });
}

// sums[b]: the sum over the blocks before b.
std::vector<std::size_t> sums_before(std::vector<std::size_t> counts) {
    std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), std::size_t{0});
    return counts;
}

}  // namespace

void MeshBuilder::begin(const Job& job) {
    wanted_ = job.want.vertices;
    want_faces_ = job.want.faces;
    unscale_ = 1 / job.scale;
    job_ = wanted_ ? job : Job{};
    const std::size_t count = wanted_ ? job.rows() : 0;
    for (Arena* memory : {&records_memory_, &vertices_memory_}) {
        if (!wanted_) *memory = {};
        memory->reset(std::clamp(256 * count, min_segment, max_segment));
    }
    blocks_.clear();
    vertices_of_.clear();
    vertices_ = 0;
    records_.resize_uninitialized(count);
    std::ranges::fill(records_, nullptr);
}

void MeshBuilder::add(std::span<const std::int32_t> cells, const MeshBlock& block) {
    const auto bytes = block.bytes();
    if (!wanted_ || bytes.empty()) return;
    const auto left_out = static_cast<std::size_t>(std::ranges::count(block.begins(), MeshBlock::none));
    std::byte *to = nullptr, *positions = nullptr, *vertices = nullptr;
    std::size_t number = 0;
    {
        const std::lock_guard lock(mutex_);
        to = records_memory_.allocate(bytes.size());
        positions = vertices_memory_.allocate(block.positions().size_bytes());
        vertices = vertices_memory_.allocate(block.vertices().size_bytes());
        if (left_out > 0) {  // they come by another block
            std::span own(reinterpret_cast<std::int32_t*>(records_memory_.allocate(cells.size_bytes())),
                          cells.size() - left_out);
            for (std::size_t k = 0, kept = 0; k < cells.size(); ++k)
                if (block.begins()[k] != MeshBlock::none) own[kept++] = cells[k];
            blocks_.push_back(own);
        } else {
            blocks_.push_back(cells);
        }
        number = vertices_of_.size();
        vertices_of_.push_back({{reinterpret_cast<const double*>(positions), block.positions().size()},
                                static_cast<std::uint32_t>(vertices_),
                                reinterpret_cast<const std::uint32_t*>(vertices)});
        vertices_ += block.positions().size() / 3;
    }
    std::memcpy(to, bytes.data(), bytes.size());
    std::ranges::copy(std::as_bytes(block.positions()), positions);
    std::ranges::copy(std::as_bytes(block.vertices()), vertices);
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (block.begins()[k] == MeshBlock::none) continue;
        std::byte* const record = to + block.begins()[k];
        MeshCellView::set_block(record, static_cast<std::uint32_t>(number));
        records_[static_cast<std::size_t>(cells[k])] = record;
    }
}

void MeshBuilder::finish(detail::Result& result, ThreadPool& pool) {
    if (!wanted_) return;
    count_vertices(result, pool);
    if (const std::int64_t places = result.cell_vertex_indptr[records_.size()];
        places > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported, "the cells have " + std::to_string(places) +
                                                " vertices, more than 2147483647: too many for one mesh");
    {
        VertexSets sets(vertices_);
        unite_vertices(sets, result, pool);
        number_vertices(result, sets, pool);
    }
    vertices_memory_.release_pages();
    if (want_faces_) place_polygons(result, pool);
    for_cells(pool, records_.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::int32_t* const all = result.cell_vertex_indices.data();
        for (std::size_t i = begin; i < end; ++i)
            std::sort(all + result.cell_vertex_indptr[i], all + result.cell_vertex_indptr[i + 1]);
    });
}

template <class Task>
void MeshBuilder::for_blocks(ThreadPool& pool, Task task) const {
    pool.run(blocks_.size(), [&](std::size_t block, unsigned) {
        for (const std::int32_t i : blocks_[block]) task(block, static_cast<std::size_t>(i));
    });
}

template <class Task>
void MeshBuilder::for_vertices(ThreadPool& pool, Task task) const {
    pool.run(vertices_of_.size(), [&](std::size_t block, unsigned) {
        const BlockVertices& vertices = vertices_of_[block];
        task(vertices.first, vertices.first + vertices.count());
    });
}

void MeshBuilder::count_vertices(detail::Result& result, ThreadPool& pool) const {
    const std::size_t count = records_.size();
    auto& indptr = result.cell_vertex_indptr;
    indptr.resize_uninitialized(count + 1);
    indptr[0] = 0;
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i + lookahead < count) __builtin_prefetch(records_[i + lookahead]);
            indptr[i + 1] = cell(i).vertices();
        }
    });
    std::partial_sum(indptr.begin(), indptr.end(), indptr.begin());
}

void MeshBuilder::unite_vertices(VertexSets& sets, const detail::Result& result, ThreadPool& pool) const {
    for_vertices(pool, [&](std::uint32_t begin, std::uint32_t end) { sets.init(begin, end); });
    const Rows rows{result.indptr, result.indices, result.shifts};
    if (!job_.probes_of)
        for_blocks(pool, [&](std::size_t, std::size_t i) {
            FaceMatcher(job_, rows, records_, vertices_of_, sets).unite_faces(i);
        });
    for_vertices(pool, [&](std::uint32_t begin, std::uint32_t end) { sets.flatten(begin, end); });
}

// A vertex of the mesh is a set and a translation: it is numbered, and placed, by the first cell that has it.
void MeshBuilder::number_vertices(detail::Result& result, VertexSets& sets, ThreadPool& pool) const {
    struct Moved {
        std::uint32_t root;
        exact::Shift shift;
        std::uint32_t place;
    };
    const auto& indptr = result.cell_vertex_indptr;
    const std::size_t count = records_.size(), tasks = ceil_div(count, task_cells);
    // By root: the first place, in the order of the cells, of those that are not moved.
    Buffer<std::uint32_t> least;
    least.resize_uninitialized(vertices_);
    for_vertices(pool, [&](std::uint32_t begin, std::uint32_t end) {
        std::fill(least.begin() + begin, least.begin() + end, ~std::uint32_t{0});
    });
    std::vector<std::vector<Moved>> moved_in(blocks_.size());
    for_blocks(pool, [&](std::size_t block, std::size_t i) {
        const MeshCellView view = cell(i);
        const BlockVertices& vertices = vertices_of_[block];
        const std::uint32_t* const of_cell = vertices.of_cells + view.first();
        for (std::uint32_t v = 0; v < view.vertices(); ++v) {
            const std::uint32_t vertex = vertices.first + of_cell[v];
            const auto place = static_cast<std::uint32_t>(indptr[i]) + v;
            if (sets.is_moved(vertex)) {
                const ShiftedVertex root = sets.find(vertex);
                moved_in[block].push_back({root.vertex, root.shift, place});
                continue;
            }
            const std::atomic_ref smallest(least[sets.root(vertex)]);
            for (std::uint32_t before = smallest.load(std::memory_order_relaxed);
                 place < before && !smallest.compare_exchange_weak(before, place, std::memory_order_relaxed);) {
            }
        }
    });

    auto& first = result.cell_vertex_indices;  // for now, the first place of the same vertex
    first.resize_uninitialized(static_cast<std::size_t>(indptr[count]));
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (i + lookahead < end) __builtin_prefetch(records_[i + lookahead]);
            const MeshCellView view = cell(i);
            if (view.vertices() == 0) continue;
            const BlockVertices& vertices = vertices_of_[view.block()];
            const std::uint32_t* const of_cell = vertices.of_cells + view.first();
            for (std::uint32_t v = 0; v < view.vertices(); ++v)
                first[static_cast<std::size_t>(indptr[i]) + v] =
                    static_cast<std::int32_t>(least[sets.root(vertices.first + of_cell[v])]);
        }
    });
    std::vector<Moved> moved;
    for (const auto& some : moved_in) moved.insert(moved.end(), some.begin(), some.end());
    std::ranges::sort(moved, [](const Moved& a, const Moved& b) {
        return std::tie(a.root, a.shift, a.place) < std::tie(b.root, b.shift, b.place);
    });
    for (std::size_t k = 0, leader = 0; k < moved.size(); ++k) {
        if (moved[k].root != moved[leader].root || moved[k].shift != moved[leader].shift) leader = k;
        first[moved[k].place] = static_cast<std::int32_t>(moved[leader].place);
    }

    std::vector<std::size_t> firsts(tasks);
    const auto is_first = [&](std::int64_t place) { return first[static_cast<std::size_t>(place)] == place; };
    for_cells(pool, count, [&](std::size_t task, std::size_t begin, std::size_t end) {
        for (std::int64_t place = indptr[begin]; place < indptr[end]; ++place) firsts[task] += is_first(place) ? 1 : 0;
    });
    const std::vector<std::size_t> numbers = sums_before(firsts);
    result.vertices.resize_uninitialized(tasks == 0 ? 0 : 3 * (numbers.back() + firsts.back()));
    // The first vertex of each set gets -1 - number; other entries are places.
    const auto number_at = [&](std::size_t place) { return -1 - first[place]; };
    for_cells(pool, count, [&](std::size_t task, std::size_t begin, std::size_t end) {
        std::size_t number = numbers[task];
        for (std::size_t i = begin; i < end; ++i) {
            if (i + lookahead < end) __builtin_prefetch(records_[i + lookahead]);
            const MeshCellView view = cell(i);
            if (view.vertices() == 0) continue;
            const BlockVertices& vertices = vertices_of_[view.block()];
            for (std::uint32_t v = 0; v < view.vertices(); ++v) {
                const std::int64_t place = indptr[i] + v;
                if (!is_first(place)) continue;
                const double* const at =
                    vertices.positions.data() + std::size_t{3} * vertices.of_cells[view.first() + v];
                for (std::size_t k = 0; k < 3; ++k) result.vertices[3 * number + k] = at[k] * unscale_;
                first[static_cast<std::size_t>(place)] =
                    static_cast<std::int32_t>(-1 - static_cast<std::int64_t>(number));
                ++number;
            }
        }
    });
    if (!moved.empty()) {
        // The other vertices of a set are images of its first.
        const std::size_t vertices = result.vertices.size() / 3;
        result.vertex_image_of.resize_uninitialized(vertices);
        result.vertex_shifts.resize_uninitialized(3 * vertices);
        std::iota(result.vertex_image_of.begin(), result.vertex_image_of.end(), 0);
        std::ranges::fill(result.vertex_shifts, 0);
        for (std::size_t k = 0; k < moved.size();) {
            const std::size_t group = k;
            // The vertices at the root's own place come first, then the moved ones.
            std::uint32_t best = least[moved[group].root];
            exact::Shift from{};
            for (; k < moved.size() && moved[k].root == moved[group].root; ++k)
                if (moved[k].place < best) best = moved[k].place, from = moved[k].shift;
            const auto note = [&](std::uint32_t place, const exact::Shift& shift) {
                const auto vertex = static_cast<std::size_t>(number_at(place));
                result.vertex_image_of[vertex] = number_at(best);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    result.vertex_shifts[3 * vertex + axis] = static_cast<std::int8_t>(shift[axis] - from[axis]);
            };
            note(least[moved[group].root], {});
            for (std::size_t m = group; m < k; ++m)
                if (first[moved[m].place] < 0) note(moved[m].place, moved[m].shift);
        }
    }
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::int64_t place = indptr[begin]; place < indptr[end]; ++place)
            if (auto& id = first[static_cast<std::size_t>(place)]; id >= 0)
                id = number_at(static_cast<std::size_t>(id));
    });
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::int64_t place = indptr[begin]; place < indptr[end]; ++place)
            if (auto& id = first[static_cast<std::size_t>(place)]; id < 0) id = -1 - id;
    });
}

void MeshBuilder::place_polygons(detail::Result& result, ThreadPool& pool) const {
    const std::size_t count = records_.size(), blocks = ceil_div(count, task_cells);
    std::vector<std::size_t> sizes(blocks);
    for_cells(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) sizes[block] += cell(i).corners();
    });
    const std::vector<std::size_t> places = sums_before(sizes);
    const std::size_t total = blocks == 0 ? 0 : places.back() + sizes.back();
    result.face_vertices.resize_uninitialized(total);
    result.face_offsets.resize_uninitialized(static_cast<std::size_t>(result.indptr[count]) + 1);
    result.face_offsets[result.face_offsets.size() - 1] = static_cast<std::int64_t>(total);
    for_cells(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::size_t place = places[block];
        for (std::size_t i = begin; i < end; ++i) {
            if (i + lookahead < end) __builtin_prefetch(records_[i + lookahead]);
            const MeshCellView view = cell(i);
            const auto row = static_cast<std::size_t>(result.indptr[i]);
            const std::int32_t* const vertices = result.cell_vertex_indices.data() + result.cell_vertex_indptr[i];
            for (std::size_t f = 0; f < view.faces(); ++f)
                result.face_offsets[row + f] = static_cast<std::int64_t>(place + view.begin(f));
            for (std::uint32_t k = 0; k < view.corners(); ++k)
                result.face_vertices[place + k] = vertices[view.corner(k)];
            place += view.corners();
        }
    });
}

}  // namespace votess
