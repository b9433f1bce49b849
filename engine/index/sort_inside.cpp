#include "index/sort_inside.hpp"

#include <utility>
#include <vector>

namespace votess::cpu {

void sort_inside(const Points& points, double scale, unsigned resolution, std::span<const CellStatus> outside,
                 SeedSorter& sorter, ThreadPool& pool, SortedSeeds& out) {
    if (outside.empty()) {
        if (points.f32.empty())
            sorter.sort(points.f64, scale, resolution, pool, out);
        else
            sorter.sort(points.f32, scale, resolution, pool, out);
        return;
    }
    std::vector<double> kept;
    std::vector<std::int32_t> input;  // of those kept
    for (std::size_t i = 0; i < outside.size(); ++i) {
        if (outside[i] == CellStatus::outside) continue;
        for (std::size_t k = 0; k < 3; ++k) kept.push_back(points[3 * i + k]);
        input.push_back(static_cast<std::int32_t>(i));
    }
    sorter.sort(kept, scale, resolution, pool, out);
    for (std::int32_t& i : out.input) i = input[static_cast<std::size_t>(i)];
    if (out.duplicates == 0) return;
    std::vector<std::int32_t> duplicate_of(points.count(), -1);
    for (std::size_t i = 0; i < input.size(); ++i)
        if (const std::int32_t first = out.duplicate_of[i]; first >= 0)
            duplicate_of[static_cast<std::size_t>(input[i])] = input[static_cast<std::size_t>(first)];
    out.duplicate_of = std::move(duplicate_of);
}

}  // namespace votess::cpu
