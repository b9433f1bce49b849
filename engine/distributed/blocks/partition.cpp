#include "distributed/blocks/partition.hpp"

#include <algorithm>
#include <array>

namespace votess::blocks {

Partition::Partition(std::vector<exact::Point> sample, std::size_t blocks) {
    split(sample, 0, sample.size(), 0, blocks);
}

std::size_t Partition::block_of(const exact::Point& place) const {
    std::size_t node = 0;
    while (nodes_[node].axis >= 0)
        node = place[static_cast<std::size_t>(nodes_[node].axis)] < nodes_[node].at ? node + 1 : nodes_[node].second;
    return nodes_[node].block;
}

void Partition::split(std::vector<exact::Point>& sample, std::size_t begin, std::size_t end, std::size_t first,
                      std::size_t blocks) {
    const std::size_t node = nodes_.size();
    nodes_.push_back({});
    nodes_[node].block = first;
    if (blocks == 1) return;
    std::array<double, 3> lower{}, upper{};
    for (std::size_t i = begin; i < end; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            lower[k] = i == begin ? sample[i][k] : std::min(lower[k], sample[i][k]);
            upper[k] = i == begin ? sample[i][k] : std::max(upper[k], sample[i][k]);
        }
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (upper[k] - lower[k] > upper[axis] - lower[axis]) axis = k;
    const std::size_t below = blocks / 2, middle = begin + (end - begin) * below / blocks;
    const auto at = [&](std::size_t i) { return sample.begin() + static_cast<std::ptrdiff_t>(i); };
    if (begin < end)
        std::nth_element(at(begin), at(middle), at(end),
                         [axis](const exact::Point& a, const exact::Point& b) { return a[axis] < b[axis]; });
    nodes_[node].axis = static_cast<int>(axis);
    nodes_[node].at = begin < end ? sample[middle][axis] : 0;
    split(sample, begin, middle, first, below);
    nodes_[node].second = nodes_.size();
    split(sample, middle, end, first + below, blocks - below);
}

}  // namespace votess::blocks
