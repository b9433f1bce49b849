#include "mesh_builder.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

namespace votess {
namespace {

constexpr std::size_t task_cells = 4096;
constexpr std::size_t least_segment = std::size_t{1} << 16, most_segment = std::size_t{32} << 20;

// task(block, begin, end)
template <class Task>
void for_cells(ThreadPool& pool, std::size_t count, Task task) {
    pool.run((count + task_cells - 1) / task_cells, [&](std::size_t block, unsigned) {
        task(block, block * task_cells, std::min(count, (block + 1) * task_cells));
    });
}

// sums[b]: what comes before block b.
std::vector<std::size_t> sums_before(std::vector<std::size_t> counts) {
    std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), std::size_t{0});
    return counts;
}

}  // namespace

void MeshBuilder::begin(const Job& job) {
    wanted_ = job.options.want.vertices;
    want_faces_ = job.options.want.faces;
    unscale_ = 1 / job.scale;
    const std::size_t count = wanted_ ? job.points.count() : 0;
    if (!wanted_) memory_ = {};
    memory_.reset(std::clamp(256 * count, least_segment, most_segment));
    records_.resize_uninitialized(count);
    std::ranges::fill(records_, nullptr);
}

void MeshBuilder::add(std::span<const std::int32_t> cells, const MeshBlock& block) {
    if (!wanted_) return;
    const auto bytes = block.bytes();
    std::byte* to = nullptr;
    {
        const std::lock_guard lock(mutex_);
        to = memory_.take(bytes.size());
    }
    if (!bytes.empty()) std::memcpy(to, bytes.data(), bytes.size());
    for (std::size_t k = 0; k < cells.size(); ++k)
        if (block.begins()[k] != MeshBlock::none) records_[static_cast<std::size_t>(cells[k])] = to + block.begins()[k];
}

void MeshBuilder::finish(detail::Result& result, ThreadPool& pool) {
    for (auto* list : {&result.face_offsets, &result.cell_vertex_indptr}) list->resize_uninitialized(0);
    for (auto* list : {&result.face_vertices, &result.cell_vertex_indices}) list->resize_uninitialized(0);
    result.vertices.resize_uninitialized(0);
    if (!wanted_) return;
    const std::size_t count = records_.size();
    result.cell_vertex_indptr.resize_uninitialized(count + 1);
    std::int64_t total = result.cell_vertex_indptr[0] = 0;
    for (std::size_t i = 0; i < count; ++i) result.cell_vertex_indptr[i + 1] = total += cell(i).vertices();
    if (total > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::unsupported, "the cells have " + std::to_string(total) +
                                                " vertices, more than 2147483647: too many for one mesh");
    VertexSets sets(static_cast<std::size_t>(total));
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        sets.init(static_cast<std::size_t>(result.cell_vertex_indptr[begin]),
                  static_cast<std::size_t>(result.cell_vertex_indptr[end]));
    });
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        FaceMatcher matcher(result, records_, sets);
        for (std::size_t i = begin; i < end; ++i) matcher.unite_faces(i);
    });
    number_vertices(result, sets, pool);
    if (want_faces_) place_polygons(result, pool);
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::int32_t* const all = result.cell_vertex_indices.data();
        for (std::size_t i = begin; i < end; ++i)
            std::sort(all + result.cell_vertex_indptr[i], all + result.cell_vertex_indptr[i + 1]);
    });
}

// A vertex of the mesh is a set and a translation: the first cell that has it, has it where it lies and first of all.
void MeshBuilder::number_vertices(detail::Result& result, VertexSets& sets, ThreadPool& pool) const {
    struct Moved {
        std::uint32_t root;
        Shift shift;
        std::uint32_t vertex;
    };
    const std::size_t count = records_.size(), blocks = (count + task_cells - 1) / task_cells;
    const auto& indptr = result.cell_vertex_indptr;
    auto& first = result.cell_vertex_indices;  // for now, the first of all that are the same vertex
    first.resize_uninitialized(static_cast<std::size_t>(indptr[count]));
    std::vector<std::vector<Moved>> moved_in(blocks);
    for_cells(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(indptr[begin]); v < indptr[end]; ++v) {
            const ShiftedVertex root = sets.find(v);
            first[v] = static_cast<std::int32_t>(root.vertex);
            if (root.shift != Shift{}) moved_in[block].push_back({root.vertex, root.shift, v});
        }
    });
    std::vector<Moved> moved;
    for (auto& some : moved_in) moved.insert(moved.end(), some.begin(), some.end());
    std::ranges::sort(moved, [](const Moved& a, const Moved& b) {
        return std::tie(a.root, a.shift, a.vertex) < std::tie(b.root, b.shift, b.vertex);
    });
    for (std::size_t k = 0, leader = 0; k < moved.size(); ++k) {
        if (moved[k].root != moved[leader].root || moved[k].shift != moved[leader].shift) leader = k;
        first[moved[k].vertex] = static_cast<std::int32_t>(moved[leader].vertex);
    }

    std::vector<std::size_t> firsts(blocks);
    const auto is_first = [&](std::int64_t v) { return first[static_cast<std::size_t>(v)] == v; };
    for_cells(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        for (std::int64_t v = indptr[begin]; v < indptr[end]; ++v) firsts[block] += is_first(v) ? 1 : 0;
    });
    const std::vector<std::size_t> numbers = sums_before(firsts);
    result.vertices.resize_uninitialized(blocks == 0 ? 0 : 3 * (numbers.back() + firsts.back()));
    for_cells(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::size_t number = numbers[block];
        for (std::size_t i = begin; i < end; ++i) {
            const MeshCellView view = cell(i);
            for (std::uint32_t v = 0; v < view.vertices(); ++v) {
                const std::int64_t place = indptr[i] + v;
                if (!is_first(place)) continue;
                for (std::size_t k = 0; k < 3; ++k)
                    result.vertices[3 * number + k] = (view.origin()[k] + view.position(v)[k]) * unscale_;
                sets.scratch(static_cast<std::size_t>(place)) = number++;
            }
        }
    });
    for_cells(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        for (std::int64_t v = indptr[begin]; v < indptr[end]; ++v) {
            auto& id = first[static_cast<std::size_t>(v)];
            id = static_cast<std::int32_t>(sets.scratch(static_cast<std::size_t>(id)));
        }
    });
}

void MeshBuilder::place_polygons(detail::Result& result, ThreadPool& pool) const {
    const std::size_t count = records_.size(), blocks = (count + task_cells - 1) / task_cells;
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
