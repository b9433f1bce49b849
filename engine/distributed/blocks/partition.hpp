// Splits space into blocks of about equal numbers of seeds: by planes across the longest side, at the quantiles of a
// sample (Bentley's k-d tree, Comm. ACM 18, 1975). Seeds at one place are in one block.
#pragma once

#include <cstddef>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::blocks {

class Partition {
public:
    // sample: places of some seeds, the same in the same order on all ranks. blocks: 1 or more.
    Partition(std::vector<exact::Point> sample, std::size_t blocks);

    [[nodiscard]] std::size_t block_of(const exact::Point& place) const;

private:
    struct Node {
        int axis = -1;  // -1: a block
        double at = 0;  // places below it belong to the first child, which is the next node
        std::size_t second = 0;
        std::size_t block = 0;
    };
    void split(std::vector<exact::Point>& sample, std::size_t begin, std::size_t end, std::size_t first,
               std::size_t blocks);

    std::vector<Node> nodes_;
};

}  // namespace votess::blocks
