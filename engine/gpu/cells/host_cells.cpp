#include "gpu/cells/host_cells.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "core/arithmetic.hpp"

namespace votess::gpu {
namespace {

constexpr std::size_t block_cells = 4096;  // per task

}  // namespace

double Numbers::operator[](std::size_t i) const {
    if (float64) {
        double value = 0;
        std::memcpy(&value, bytes.data() + i * each, sizeof value);
        return value;
    }
    float halves[2];
    std::memcpy(halves, bytes.data() + i * each, sizeof halves);
    return static_cast<double>(halves[0]) + static_cast<double>(halves[1]);
}

void HostCells::measure(std::size_t member, const Numbers& geometry) const {
    const Job& job = *s_.job;
    const Want& want = job.want;
    const auto i = static_cast<std::size_t>(input_of(member));
    const int exponent = exponent_of(member);
    if (want.volumes) s_.result->arrays().volumes[i] = times_power_of_two(geometry[0], 3 * exponent - flat_);
    if (!want.centroids) return;
    for (std::size_t k = 0; k < 3; ++k)
        s_.result->arrays().centroids[3 * i + k] = job.points[3 * i + k] + (s_.wraps.empty() ? 0 : s_.wraps[i][k]) +
                                                   times_power_of_two(geometry[1 + k], exponent);
}

void HostCells::finish(std::size_t first, std::size_t count, const Numbers& geometry) const {
    ResultBuilder& result = *s_.result;
    const Want& want = s_.job->want;
    s_.pool->run(ceil_div(count, block_cells), [&](std::size_t block, unsigned) {
        const std::size_t begin = first + block * block_cells, end = std::min(first + count, begin + block_cells);
        CellCounters counters;
        for (std::size_t member = begin; member < end; ++member) {
            if (!is_certified(member)) continue;
            const std::uint32_t info = s_.info[member], faces = (info >> INFO_FACES_SHIFT) & 0xff;
            counters.faces += faces;
            if (want.volumes || want.centroids) measure(member, geometry.from((member - first) * numbers_each));
            if (!want.counts) continue;
            const auto i = static_cast<std::size_t>(input_of(member));
            const std::uint32_t vertices = (info >> INFO_VERTICES_SHIFT) & 0xff;
            result.arrays().face_counts[i] = faces;
            result.arrays().edge_counts[i] = vertices + faces - 2;  // Euler
            result.arrays().vertex_counts[i] = vertices;
        }
        result.count(counters);
    });
}

void HostCells::set_empty() const {
    s_.pool->run(ceil_div(s_.info.size(), block_cells), [&](std::size_t block, unsigned) {
        const std::size_t end = std::min(s_.info.size(), (block + 1) * block_cells);
        CellCounters counters;
        for (std::size_t member = block * block_cells; member < end; ++member) {
            if ((s_.info[member] & 0xff) != STATUS_EMPTY) continue;
            ++counters.empty_cells;
            s_.result->set_empty(static_cast<std::size_t>(input_of(member)), CellStatus::empty);
        }
        s_.result->count(counters);
    });
}

void HostCells::for_blocks_of(const DeviceRows& rows, const auto& task) const {
    const std::size_t count = rows.lengths.size(), blocks = ceil_div(count, block_cells);
    std::vector<std::size_t> begins(blocks + 1, 0);
    for (std::size_t b = 0; b < blocks; ++b) {
        const auto of_block = rows.lengths.subspan(b * block_cells, std::min(block_cells, count - b * block_cells));
        begins[b + 1] = std::accumulate(of_block.begin(), of_block.end(), begins[b]);
    }
    s_.pool->run(blocks, [&](std::size_t block, unsigned) {
        const std::size_t entry = begins[block], entries = begins[block + 1] - entry;
        const std::size_t first = rows.first + block * block_cells;
        const auto lengths =
            rows.lengths.subspan(block * block_cells, std::min(block_cells, count - block * block_cells));
        std::vector<double> areas;
        if (s_.job->want.areas) {
            areas.reserve(entries);
            for (std::size_t c = 0; c < lengths.size(); ++c)
                for (std::uint32_t k = 0; k < lengths[c]; ++k)
                    areas.push_back(
                        times_power_of_two(rows.areas[entry + areas.size()], 2 * exponent_of(first + c) - flat_));
        }
        const auto shifts = rows.shifts.empty() ? rows.shifts : rows.shifts.subspan(3 * entry, 3 * entries);
        task(first, lengths, rows.ids.subspan(entry, entries), RowValues{areas, {}, shifts});
    });
}

void HostCells::place(const DeviceRows& rows) const {
    for_blocks_of(rows, [&](std::size_t first, const auto& lengths, const auto& ids, const RowValues& values) {
        s_.result->place_rows(first, lengths, ids, values);
    });
}

void HostCells::keep(const DeviceRows& rows) const {
    for_blocks_of(rows, [&](std::size_t first, const auto& lengths, const auto& ids, const RowValues& values) {
        std::array<std::int32_t, block_cells> cells;
        for (std::size_t c = 0; c < lengths.size(); ++c) cells[c] = input_of(first + c);
        s_.result->copy_rows(std::span(cells).first(lengths.size()), lengths, ids, values);
    });
}

void HostCells::clip(const DeviceRows& rows, ExactClipper& clipper, const Share& share) const {
    std::vector<std::int32_t> cells;
    std::vector<std::uint32_t> lengths;
    for (std::size_t c = 0; c < rows.lengths.size(); ++c) {
        if (!is_certified(rows.first + c)) continue;
        cells.push_back(input_of(rows.first + c));
        lengths.push_back(rows.lengths[c]);
    }
    using Shift = std::array<std::int8_t, 3>;
    static_assert(sizeof(Shift) == 3);
    const std::span shifts(reinterpret_cast<const Shift*>(rows.shifts.data()), rows.shifts.size() / 3);
    clipper.clip_listed({cells, lengths, rows.ids, shifts}, *s_.result, share);
}

}  // namespace votess::gpu
