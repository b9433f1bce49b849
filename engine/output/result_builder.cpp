#include "output/result_builder.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "core/arithmetic.hpp"
#include "core/errors.hpp"
#include "core/sum.hpp"
#include "core/system.hpp"
#include "core/vector3.hpp"
#include "input/settled.hpp"
#include "result/arrays.hpp"
#include "result/drop_faces.hpp"

namespace votess {
namespace {

constexpr std::size_t copied_block = 4096;  // cells
constexpr std::size_t task_cells = 65536;   // of loops over all cells; fixed, so that sums do not depend on threads
constexpr std::size_t min_segment = std::size_t{64} << 10, max_segment = std::size_t{8} << 20;
constexpr std::size_t lookahead = 16;                          // cells whose places are prefetched
constexpr std::size_t fewest_in_parts = std::size_t{1} << 16;  // cells
constexpr std::size_t pending_row = 46;  // bytes of a pending row in a part, which is usually a little less

template <class Task>
void for_blocks(ThreadPool& pool, std::size_t count, Task task) {
    pool.run(ceil_div(count, task_cells), [&](std::size_t block, unsigned) {
        task(block, block * task_cells, std::min(count, (block + 1) * task_cells));
    });
}

template <class T>
void fill(Buffer<T>& buffer, std::size_t count, T value, ThreadPool& pool) {
    buffer.resize_uninitialized(count);
    buffer.touch(0, count, pool);
    for_blocks(pool, count, [&](std::size_t, std::size_t begin, std::size_t end) {
        std::fill(buffer.data() + begin, buffer.data() + end, value);
    });
}

// So 1e9 volumes sum to the last digits.
double accurate_sum(std::span<const double> values) {
    Sum sum;
    for (const double value : values) sum += value;
    // Beyond the largest double the corrections are NaN.
    return std::isfinite(sum.value()) ? sum.value() : std::accumulate(values.begin(), values.end(), 0.0);
}

std::size_t sum_of(std::span<const std::uint32_t> lengths) {
    return std::accumulate(lengths.begin(), lengths.end(), std::size_t{0});
}

}  // namespace

void ResultBuilder::begin(const Job& job, ThreadPool& pool) {
    const std::size_t count = job.rows();
    const Want& want = job.want;
    const bool larger = job.arrays != nullptr && job.arrays->status.capacity() > result_.status.capacity();
    result_ = detail::emptied(std::move(larger ? *job.arrays : result_));
    blocks_.clear();
    settled_ = false;
    touched_cells_ = touched_entries_ = 0;
    stock_.clear();
    for (auto* memory : {&cells_memory_, &ids_memory_, &areas_memory_, &normals_memory_, &shifts_memory_})
        memory->reset(std::clamp(8 * count, min_segment, max_segment), &stock_);
    // Values of entries take more memory than the rows.
    has_parts_ = want.neighbors && !want.areas && !want.normals && count >= fewest_in_parts;
    part_bits_ = static_cast<int>(std::bit_width(ceil_div(std::max<std::size_t>(count, 1), max_parts) - 1));
    for (std::size_t k = 0; k < max_parts; ++k) {
        const std::size_t cells = std::min(count, (k + 1) << part_bits_) - std::min(count, k << part_bits_);
        parts_[k].memory.reset(std::max(pending_row * cells, min_segment), &stock_);  // in one piece
        parts_[k].blocks.clear();
    }
    counters_ = {};
    faces_.begin(0);
    scale_ = job.scale;
    unit_ = job.unit();
    want_neighbors_ = want.neighbors;
    want_areas_ = want.areas;
    want_normals_ = want.normals;
    want_shifts_ = want.neighbors && job.domain->is_periodic();
    result_.box = job.box;
    result_.periodic = job.domain->periodic;
    result_.cell = job.region.cell;
    result_.thickness = job.region.thickness;
    result_.walls = job.region.walls;
    if (job.reports_weights) {
        result_.weights.resize_uninitialized(job.only ? count : job.domain->weights.size());
        // Scaling by a power of two loses nothing.
        for (std::size_t i = 0; i < result_.weights.size(); ++i) {
            const std::size_t seed = job.only ? static_cast<std::size_t>(job.only->ids()[i]) : i;
            result_.weights[i] = job.domain->weights[seed] / job.scale / job.scale;
        }
    }
    box_volume_ = job.box_volume;
    result_.lists_walls = job.list_walls;
    result_.probed = job.probes_of.has_value();
    if (job.only) {
        result_.is_subset = true;
        result_.ids.resize_uninitialized(count);
        std::ranges::copy(job.only->ids(), result_.ids.begin());
    }
    min_face_ = job.min_face;
    min_area_ = job.min_area;
    fill(result_.status, count, CellStatus::certified, pool);
    if (want.neighbors) fill(result_.indptr, count + 1, std::int64_t{0}, pool);
    for_row_arrays([&](const auto& array, std::size_t) {
        if (array.per == Per::cell && array.word != nullptr && want.*array.word)
            array.of(result_).resize_uninitialized(array.components * count);
    });
    mesh_.begin(job);
}

void ResultBuilder::touch(double share, double row, ThreadPool& pool) {
    const auto count = static_cast<double>(result_.status.size());
    const auto cells = static_cast<std::size_t>(share * count);
    if (cells > touched_cells_) {
        if (!result_.volumes.empty()) result_.volumes.touch(touched_cells_, cells, pool);
        if (!result_.centroids.empty()) result_.centroids.touch(3 * touched_cells_, 3 * cells, pool);
        touched_cells_ = cells;
    }
    if (!want_neighbors_ || row == 0) return;
    constexpr double longest = 20, longer = 1.2;  // later rows may be longer, and untouched memory costs nothing
    row = std::min(row, longest);
    if (result_.indices.empty()) resize_entries(static_cast<std::size_t>(longer * row * count));
    touch_entries(std::min(static_cast<std::size_t>(share * row * count), result_.indices.size()), pool);
}

void ResultBuilder::resize_entries(std::size_t entries) {
    if (entries > result_.indices.capacity()) touched_entries_ = 0;
    result_.indices.resize_uninitialized(entries);
    result_.face_areas.resize_uninitialized(want_areas_ ? entries : 0);
    result_.face_normals.resize_uninitialized(want_normals_ ? 3 * entries : 0);
    result_.shifts.resize_uninitialized(want_shifts_ ? 3 * entries : 0);
}

void ResultBuilder::touch_entries(std::size_t end, ThreadPool& pool) {
    const std::size_t begin = touched_entries_;
    if (end <= begin) return;
    touched_entries_ = end;
    result_.indices.touch(begin, end, pool);
    if (want_areas_) result_.face_areas.touch(begin, end, pool);
    if (want_normals_) result_.face_normals.touch(3 * begin, 3 * end, pool);
    if (want_shifts_) result_.shifts.touch(3 * begin, 3 * end, pool);
}

void ResultBuilder::add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                             std::span<const std::int32_t> ids, const RowValues& values) {
    if (!want_neighbors_) return;
    check_values(values, ids.size(), want_shifts_);
    // Otherwise a row from another call would count as one of this block.
    const bool gaps = set_lengths(cells, lengths, ids.size());
    push(cells, lengths, {.ids = keep_copy(ids, ids_memory_)}, values, gaps);
}

void ResultBuilder::add_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                             const NearRows& near, const RowValues& values, std::span<const RowShift> shifts) {
    if (!want_neighbors_) return;
    const auto rows = static_cast<std::size_t>(std::ranges::count_if(lengths, [](auto n) { return n > 0; }));
    if (near.steps.size() < rows) bug("rows and their lengths differ in size");
    const std::size_t entries = near.steps.size() - rows;
    check_values(values, entries, false);
    const bool gaps = set_lengths(cells, lengths, entries);
    const NearRows kept{keep_copy(near.steps, ids_memory_), keep_copy(near.others, ids_memory_), near.input};
    push(cells, lengths, {.near = kept, .shifts = keep_copy(shifts, shifts_memory_)}, values, gaps);
}

void ResultBuilder::add_rows_of_part(std::size_t part, std::span<const std::int32_t> cells,
                                     std::span<const std::uint32_t> lengths, const NearRows& near,
                                     std::span<const RowShift> shifts) {
    if (near.steps.size() < cells.size()) bug("rows and their lengths differ in size");
    for (const std::int32_t cell : cells)
        if (part_of(static_cast<std::uint32_t>(cell)) != part) bug("a row is in another part than its cell");
    if (set_lengths(cells, lengths, near.steps.size() - cells.size())) bug("a row of a part is empty");
    Arena& memory = parts_[part].memory;
    const NearRows kept{keep_copy(near.steps, memory), keep_copy(near.others, memory), near.input};
    const Block block{.cells = keep_copy(cells, memory), .near = kept, .shifts = keep_copy(shifts, shifts_memory_)};
    const std::lock_guard lock(mutex_);
    parts_[part].blocks.push_back(block);
}

void ResultBuilder::release_spare() {
    if (has_parts_) stock_.shrink(pending_row * result_.status.size());
}

void ResultBuilder::copy_rows(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                              std::span<const std::int32_t> ids, const RowValues& values) {
    if (!want_neighbors_) return;
    if (sum_of(lengths) != ids.size()) bug("rows and their lengths differ in size");
    check_values(values, ids.size(), want_shifts_);
    for (std::size_t begin = 0, entry = 0; begin < cells.size(); begin += copied_block) {
        const auto part = cells.subspan(begin, std::min(copied_block, cells.size() - begin));
        const auto part_lengths = lengths.subspan(begin, part.size());
        const std::size_t size = sum_of(part_lengths);
        const RowValues part_values{want_areas_ ? values.areas.subspan(entry, size) : values.areas,
                                    want_normals_ ? values.normals.subspan(3 * entry, 3 * size) : values.normals,
                                    want_shifts_ ? values.shifts.subspan(3 * entry, 3 * size) : values.shifts};
        set_lengths(part, part_lengths, size);
        push(part, part_lengths, {.ids = keep_copy(ids.subspan(entry, size), ids_memory_)}, part_values, true);
        entry += size;
    }
}

std::span<std::int32_t> ResultBuilder::allocate_cells(std::size_t count) {
    const std::lock_guard lock(mutex_);
    return {reinterpret_cast<std::int32_t*>(cells_memory_.allocate(count * sizeof(std::int32_t))), count};
}

void ResultBuilder::count(const CellCounters& counters) {
    const std::lock_guard lock(mutex_);
    counters_.faces += counters.faces;
    counters_.exact_cells += counters.exact_cells;
    counters_.fallback_cells += counters.fallback_cells;
    counters_.empty_cells += counters.empty_cells;
    counters_.kept_cells += counters.kept_cells;
}

void ResultBuilder::count(const FaceTally& faces) {
    const std::lock_guard lock(mutex_);
    faces_.add(faces);
}

void ResultBuilder::check_values(const RowValues& values, std::size_t ids, bool shifts) const {
    if (want_areas_ && values.areas.size() != ids) bug("rows and their areas differ in size");
    if (want_normals_ && values.normals.size() != 3 * ids) bug("rows and their normals differ in size");
    if (shifts && values.shifts.size() != 3 * ids) bug("rows and their shifts differ in size");
}

// The checks keep an engine's bug from writing beyond the arrays in place_rows().
bool ResultBuilder::set_lengths(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                                std::size_t ids) {
    if (cells.size() != lengths.size()) bug("cells and row lengths differ in size");
    auto& indptr = result_.indptr;
    const auto place_of = [&](std::size_t k) { return static_cast<std::uint32_t>(cells[k]) + std::size_t{1}; };
    std::size_t sum = 0, rows = 0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
        if (k + lookahead < cells.size()) __builtin_prefetch(indptr.data() + place_of(k + lookahead), 1);
        if (lengths[k] == 0) continue;
        const std::size_t i = place_of(k);
        if (i >= indptr.size() || indptr[i] != 0) bug("cell " + std::to_string(cells[k]) + " has no place for its row");
        indptr[i] = lengths[k];
        sum += lengths[k];
        ++rows;
    }
    if (sum != ids) bug("rows and their lengths differ in size");
    return rows < cells.size();
}

template <class T>
std::span<const T> ResultBuilder::keep_copy(std::span<const T> values, Arena& memory) {
    if (values.empty()) return {};
    std::byte* to = nullptr;
    {
        const std::lock_guard lock(mutex_);
        to = memory.allocate(values.size_bytes());
    }
    std::memcpy(to, values.data(), values.size_bytes());
    return {reinterpret_cast<const T*>(to), values.size()};
}

// Few rows lie across an edge of the box, so most shifts are 0.
std::span<const RowShift> ResultBuilder::keep_shifts(std::span<const std::uint32_t> lengths,
                                                     std::span<const std::int8_t> shifts) {
    std::vector<RowShift> kept;
    const std::int8_t* of_row = shifts.data();
    std::uint32_t row = 0;
    for (const std::uint32_t length : lengths) {
        if (length == 0) continue;
        int bits = 0;
        for (std::size_t k = 0; k < std::size_t{3} * length; ++k) bits |= of_row[k];
        for (std::uint32_t entry = 0; bits != 0 && entry < length; ++entry) {
            const std::int8_t* const s = of_row + std::size_t{3} * entry;
            if ((s[0] | s[1] | s[2]) != 0) kept.push_back({row, entry, {s[0], s[1], s[2]}});
        }
        of_row += std::size_t{3} * length;
        ++row;
    }
    return keep_copy(std::span<const RowShift>(kept), shifts_memory_);
}

void ResultBuilder::push(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths, Block block,
                         const RowValues& values, bool copy_cells) {
    if (block.ids.empty() && block.near.steps.empty()) return;
    if (want_areas_) block.areas = keep_copy(values.areas, areas_memory_);
    if (want_normals_) block.normals = keep_copy(values.normals, normals_memory_);
    if (want_shifts_ && !values.shifts.empty()) block.shifts = keep_shifts(lengths, values.shifts);
    block.cells = cells;
    if (copy_cells) {
        const auto rows = static_cast<std::size_t>(std::ranges::count_if(lengths, [](auto n) { return n > 0; }));
        const std::span<std::int32_t> own = allocate_cells(rows);
        for (std::size_t k = 0, kept = 0; k < cells.size(); ++k)
            if (lengths[k] > 0) own[kept++] = cells[k];
        block.cells = own;
    }
    const std::lock_guard lock(mutex_);
    blocks_.push_back(block);
}

void ResultBuilder::set_empty(std::size_t i, CellStatus status) {
    for_row_arrays([&](const auto& array, std::size_t) {
        auto& values = array.of(result_);
        if (array.per != Per::cell || array.word == nullptr || values.empty()) return;
        using Value = std::remove_reference_t<decltype(values[0])>;
        const Value none = array.components == 3 ? std::numeric_limits<Value>::quiet_NaN() : Value{};
        std::fill_n(values.data() + array.components * i, array.components, none);
    });
    result_.status[i] = status;
}

void ResultBuilder::set_duplicates(std::span<const std::int32_t> duplicate_of, ThreadPool& pool, bool have_cells) {
    auto& r = result_;
    r.duplicate_of.resize_uninitialized(duplicate_of.size());
    std::atomic<std::uint64_t> duplicates{0};
    for_blocks(pool, duplicate_of.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::uint64_t found = 0;
        for (std::size_t i = begin; i < end; ++i) {
            r.duplicate_of[i] = duplicate_of[i];
            if (duplicate_of[i] < 0) continue;
            ++found;
            if (have_cells)
                r.status[i] = CellStatus::duplicate;
            else
                set_empty(i, CellStatus::duplicate);
        }
        duplicates += found;
    });
    r.stats.duplicates = duplicates;
}

void ResultBuilder::finish(detail::Result& result, ThreadPool& pool) {
    check_status(pool);
    if (!settled_) settle({}, pool);
    mesh_.finish(result_, pool);
    if (faces_.cells() == 0 && !result_.face_offsets.empty()) measure_polygons(pool);
    if (min_face_ > 0 || min_area_ > 0) counters_.faces -= drop_small_faces(result_, min_face_, min_area_);
    finish_stats(result_.stats, pool);
    result_.stats.device = std::move(result.stats.device);
    result_.stats.seconds = result.stats.seconds;
    result = std::move(result_);
    result_ = {};
}

void ResultBuilder::check_status(ThreadPool& pool) const {
    const auto& status = result_.status;
    std::atomic<std::size_t> first = status.size();
    for_blocks(pool, status.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        const auto finished = [](CellStatus s) {
            return s == CellStatus::certified || s == CellStatus::duplicate || s == CellStatus::empty ||
                   s == CellStatus::outside;
        };
        const auto at = static_cast<std::size_t>(
            std::find_if_not(status.data() + begin, status.data() + end, finished) - status.data());
        for (std::size_t before = first; at < end && at < before && !first.compare_exchange_weak(before, at);) {
        }
    });
    if (first < status.size()) bug("cell " + std::to_string(first) + " has no final status");
}

void ResultBuilder::settle(std::span<const std::uint32_t> later, ThreadPool& pool) {
    settled_ = true;
    if (!want_neighbors_) return;
    sum_lengths(later, pool);
    for (auto* memory : {&ids_memory_, &areas_memory_, &normals_memory_, &shifts_memory_}) memory->give_rest();
    // One array after the other: where the pending values of the largest were, the next ones find pages.
    if (want_normals_) place_values(&Block::normals, normals_memory_, result_.face_normals, 3, pool);
    if (want_areas_) place_values(&Block::areas, areas_memory_, result_.face_areas, 1, pool);
    if (want_shifts_) place_shifts(pool);
    if (has_parts_)
        place_ids_of_parts(pool);
    else
        make_room(result_.indices, 1, true, pool);
    pool.run(blocks_.size(), [&](std::size_t index, unsigned) { place_ids(blocks_[index]); });
}

template <class T>
bool ResultBuilder::make_array(Buffer<T>& array, std::size_t components) {
    const std::size_t size = components * static_cast<std::size_t>(result_.indptr[result_.indptr.size() - 1]);
    const bool is_new = size > array.capacity();
    array.resize_uninitialized(size);
    return is_new;
}

template <class T>
void ResultBuilder::make_present(Buffer<T>& array, std::size_t components, bool is_new, std::size_t begin,
                                 std::size_t end, bool is_last, ThreadPool& pool) {
    const std::size_t first = components * std::max(begin, is_new ? 0 : touched_entries_), last = components * end;
    if (is_new && first < last) {
        // With the rest of its last huge page, where the next part begins.
        const std::span<std::byte> all = array.memory();
        const std::size_t from = sizeof(T) * first, to = sizeof(T) * last;
        const std::size_t rest = -reinterpret_cast<std::uintptr_t>(all.data() + to) % system::huge_page;
        stock_.move_to(all.subspan(from, std::min(to + rest, all.size()) - from), all.size());
    }
    if (is_last) stock_.release();
    if (first < last) array.touch(first, last, pool);
}

template <class T>
bool ResultBuilder::make_room(Buffer<T>& array, std::size_t components, bool is_last, ThreadPool& pool) {
    const bool is_new = make_array(array, components);
    make_present(array, components, is_new, 0, array.size() / components, is_last, pool);
    return is_new;
}

void ResultBuilder::place_ids_of_parts(ThreadPool& pool) {
    const std::size_t count = result_.status.size();
    const bool is_new = make_array(result_.indices, 1);
    for (auto& part : parts_) part.memory.give_rest();
    for (std::size_t k = 0; k < max_parts; ++k) {
        const auto begin_of = [&](std::size_t part) {
            return static_cast<std::size_t>(result_.indptr[std::min(count, part << part_bits_)]);
        };
        make_present(result_.indices, 1, is_new, begin_of(k), begin_of(k + 1), k + 1 == max_parts, pool);
        const auto& blocks = parts_[k].blocks;
        pool.run(blocks.size(), [&](std::size_t index, unsigned) { place_ids(blocks[index]); });
        parts_[k].memory.give_all();
    }
}

void ResultBuilder::place_values(std::span<const double> Block::*values, Arena& memory, Buffer<double>& array,
                                 std::size_t components, ThreadPool& pool) {
    const bool is_new = make_room(array, components, false, pool);
    pool.run(blocks_.size(), [&](std::size_t index, unsigned) {
        const double* from = (blocks_[index].*values).data();
        for_rows(blocks_[index].cells, array, components, [&](std::size_t, std::size_t begin, std::size_t length) {
            std::copy_n(from, components * length, array.data() + components * begin);
            from += components * length;
        });
    });
    if (is_new) memory.give_all();
}

void ResultBuilder::place_shifts(ThreadPool& pool) {
    auto& shifts = result_.shifts;
    make_room(shifts, 3, false, pool);
    for_blocks(pool, shifts.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        std::fill(shifts.data() + begin, shifts.data() + end, std::int8_t{0});
    });
    const auto place = [&](const std::vector<Block>& blocks) {
        pool.run(blocks.size(), [&](std::size_t index, unsigned) {
            const Block& block = blocks[index];
            for (const RowShift& kept : block.shifts) {
                if (kept.row >= block.cells.size()) bug("a shift is of no row");
                const auto cell = static_cast<std::size_t>(block.cells[kept.row]);
                const std::int64_t entry = result_.indptr[cell] + kept.entry;
                if (entry >= result_.indptr[cell + 1]) bug("a shift is of no entry of its row");
                std::ranges::copy(kept.shift, shifts.data() + 3 * entry);
            }
        });
    };
    place(blocks_);
    for (const Part& part : parts_) place(part.blocks);
}

// Turns lengths into the beginnings of rows.
void ResultBuilder::sum_lengths(std::span<const std::uint32_t> later, ThreadPool& pool) {
    auto& indptr = result_.indptr;
    const std::size_t count = indptr.size() - 1;
    if (!later.empty() && later.size() != count) bug("cells and the lengths of later rows differ in size");
    std::vector<std::int64_t> begins(ceil_div(count, task_cells) + 1, 0);
    for_blocks(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::int64_t sum = std::accumulate(indptr.data() + begin + 1, indptr.data() + end + 1, std::int64_t{0});
        if (!later.empty()) sum += static_cast<std::int64_t>(sum_of(later.subspan(begin, end - begin)));
        begins[block + 1] = sum;
    });
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    for_blocks(pool, count, [&](std::size_t block, std::size_t begin, std::size_t end) {
        std::int64_t sum = begins[block];
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t length = later.empty() ? 0 : later[i];
            if (length != 0 && indptr[i + 1] != 0) bug("cell " + std::to_string(i) + " has two rows");
            indptr[i + 1] = sum += indptr[i + 1] + length;
        }
    });
}

void ResultBuilder::place_rows(std::size_t first, std::span<const std::uint32_t> lengths,
                               std::span<const std::int32_t> ids, const RowValues& values) {
    check_values(values, ids.size(), want_shifts_);
    const std::int64_t* const indptr = result_.indptr.data() + first;
    if (!settled_ || first + lengths.size() >= result_.indptr.size())
        bug("rows are placed before settle(), or beyond the last cell");
    std::size_t entry = 0;
    for (std::size_t k = 0; k < lengths.size();) {
        // Rows up to the next cell that has one from elsewhere are copied together.
        const std::int64_t begin = indptr[k];
        std::size_t size = 0;
        for (; k < lengths.size() && indptr[k + 1] - begin == static_cast<std::int64_t>(size + lengths[k]); ++k)
            size += lengths[k];
        if (size > ids.size() - entry) bug("rows and their lengths differ in size");
        copy_entries(ids.data(), values, entry, static_cast<std::size_t>(begin), size);
        entry += size;
        if (k == lengths.size()) break;
        if (lengths[k] == 0)
            ++k;
        else if (size == 0)
            bug("a row differs from its announced length");
    }
    if (entry != ids.size()) bug("rows and their lengths differ in size");
}

void ResultBuilder::place_run(std::size_t first, std::size_t end, std::span<const std::int32_t> ids,
                              std::span<const std::int8_t> shifts) {
    if (!settled_ || end >= result_.indptr.size()) bug("rows are placed before settle(), or beyond the last cell");
    const auto begin = static_cast<std::size_t>(result_.indptr[first]);
    if (static_cast<std::size_t>(result_.indptr[end]) - begin != ids.size())
        bug("rows and their lengths differ in size");
    if (shifts.size() != (want_shifts_ ? 3 * ids.size() : 0)) bug("rows and their shifts differ in size");
    std::ranges::copy(ids, result_.indices.data() + begin);
    std::ranges::copy(shifts, result_.shifts.data() + 3 * begin);
}

void ResultBuilder::place_each(std::span<const std::int32_t> cells, std::span<const std::uint32_t> lengths,
                               std::span<const std::int32_t> ids, const RowValues& values) {
    const std::size_t size = sum_of(lengths);
    if (!settled_ || cells.size() != lengths.size() || (!ids.empty() && ids.size() != size))
        bug("rows are placed before settle(), or differ from their lengths in size");
    const auto place = [&](auto from, auto& array, std::size_t components) {
        if (from.empty()) return;
        if (from.size() != components * size) bug("rows and their values differ in size");
        const auto* next = from.data();
        for_rows(cells, array, components, [&](std::size_t k, std::size_t begin, std::size_t length) {
            if (length != lengths[k]) bug("a row differs from its announced length");
            std::copy_n(next, components * length, array.data() + components * begin);
            next += components * length;
        });
    };
    place(ids, result_.indices, 1);
    place(values.areas, result_.face_areas, 1);
    place(values.normals, result_.face_normals, 3);
    place(values.shifts, result_.shifts, 3);
}

void ResultBuilder::copy_entries(const std::int32_t* ids, const RowValues& values, std::size_t from, std::size_t to,
                                 std::size_t count) {
    std::copy_n(ids + from, count, result_.indices.data() + to);
    if (want_areas_) std::copy_n(values.areas.data() + from, count, result_.face_areas.data() + to);
    if (want_normals_) std::copy_n(values.normals.data() + 3 * from, 3 * count, result_.face_normals.data() + 3 * to);
    if (want_shifts_) std::copy_n(values.shifts.data() + 3 * from, 3 * count, result_.shifts.data() + 3 * to);
}

template <class T, class Place>
void ResultBuilder::for_rows(std::span<const std::int32_t> cells, const Buffer<T>& array, std::size_t components,
                             Place place) const {
    constexpr std::size_t usual_length = 15;
    const std::int64_t* const indptr = result_.indptr.data();
    for (std::size_t k = 0; k < cells.size(); ++k) {
        // The engine's order is not the input's, so each row is somewhere else in memory.
        if (k + 2 * lookahead < cells.size()) __builtin_prefetch(indptr + cells[k + 2 * lookahead]);
        if (k + lookahead < cells.size()) {
            const T* const next = array.data() + components * static_cast<std::size_t>(indptr[cells[k + lookahead]]);
            __builtin_prefetch(next, 1);
            __builtin_prefetch(next + components * usual_length, 1);
        }
        const std::int64_t begin = indptr[cells[k]];
        place(k, static_cast<std::size_t>(begin),
              static_cast<std::size_t>(indptr[cells[k] + std::ptrdiff_t{1}] - begin));
    }
}

void ResultBuilder::place_ids(const Block& block) {
    std::int32_t* const indices = result_.indices.data();
    NearReader near(block.near);
    const std::int32_t* ids = block.ids.data();
    const auto each = [&](auto place) { for_rows(block.cells, result_.indices, 1, place); };
    if (block.ids.empty())
        each([&](std::size_t, std::size_t begin, std::size_t length) { near.read(indices + begin, length); });
    else
        each([&](std::size_t, std::size_t begin, std::size_t length) {
            std::copy_n(ids, length, indices + begin);
            ids += length;
        });
}

// Measures at the scale of the job, where no square overflows.
void ResultBuilder::measure_polygons(ThreadPool& pool) {
    const detail::Result& r = result_;
    const auto corner = [&](std::int64_t k) {
        const double* x = &r.vertices[3 * static_cast<std::size_t>(r.face_vertices[static_cast<std::size_t>(k)])];
        return Vector3{x[0] * scale_, x[1] * scale_, x[2] * scale_};
    };
    for_blocks(pool, r.status.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
        FaceTally tally;
        tally.begin(std::numeric_limits<double>::max());
        std::vector<double> areas;
        for (std::size_t i = begin; i < end; ++i) {
            if (r.status[i] != CellStatus::certified) continue;
            areas.clear();
            for (auto entry = static_cast<std::size_t>(r.indptr[i]); entry < static_cast<std::size_t>(r.indptr[i + 1]);
                 ++entry) {
                if (r.indices[entry] < 0) continue;
                const std::int64_t first = r.face_offsets[entry], last = r.face_offsets[entry + 1];
                const Vector3 apex = corner(first);
                Vector3 twice{};
                for (std::int64_t k = first + 1; k + 1 < last; ++k) {
                    const Vector3 part = cross(minus(corner(k), apex), minus(corner(k + 1), apex));
                    for (std::size_t axis = 0; axis < 3; ++axis) twice[axis] += part[axis];
                }
                areas.push_back(0.5 * std::sqrt(dot(twice, twice)));
            }
            tally.add(areas);
        }
        count(tally);
    });
}

// Counts tiny faces that have not been dropped.
void ResultBuilder::count_tiny_faces(Stats& stats) const {
    stats.tiny_faces = faces_.count();
    if (result_.least_face == 0) return;
    const double limit = unit_.area(faces_.limit());
    std::uint64_t count = 0;
    for (std::size_t entry = 0; entry < result_.indices.size() && result_.least_face < limit; ++entry)
        count += result_.indices[entry] >= 0 && result_.face_areas[entry] < limit ? 1 : 0;
    stats.tiny_faces = count;
}

void ResultBuilder::finish_stats(Stats& stats, ThreadPool& pool) const {
    stats.points = result_.status.size();
    stats.empty_cells = stats.duplicates + counters_.empty_cells;
    stats.faces = counters_.faces;
    stats.exact_cells = counters_.exact_cells;
    stats.fallback_cells = counters_.fallback_cells;
    stats.kept_cells = counters_.kept_cells;
    const auto cells = stats.points - stats.empty_cells;
    stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
    const std::span<const double> volumes = result_.volumes;
    std::vector<double> sums(ceil_div(volumes.size(), task_cells));
    for_blocks(pool, volumes.size(), [&](std::size_t block, std::size_t begin, std::size_t end) {
        sums[block] = accurate_sum(volumes.subspan(begin, end - begin));
    });
    stats.volume_sum = accurate_sum(sums);
    if (faces_.cells() == cells && !result_.probed && !result_.is_subset) count_tiny_faces(stats);
    stats.box_volume = box_volume_;
    stats.threads = pool.size();
    stats.peak_memory_bytes = system::peak_memory();
}

}  // namespace votess
