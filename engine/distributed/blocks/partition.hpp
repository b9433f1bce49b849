// Splits space into blocks of about equal numbers of seeds: by planes across the longest side, at the quantiles of a
// sample (Bentley's k-d tree, Comm. ACM 18, 1975). Seeds at one place are in one block.
#pragma once

#include <cstddef>
#include <vector>

#include "exact/predicate.hpp"

namespace votess::blocks {

class Partition {
public:
    // sample: places of some of the seeds, in the same order everywhere. blocks: 1 or more.
    Partition(std::vector<exact::Point> sample, std::size_t blocks);

    [[nodiscard]] std::size_t block_of(const exact::Point& place) const;

private:
    struct Node {
        int axis = -1;  // of a block: none
        double at = 0;  // places below go to the first child, the next node; others to the second
        std::size_t second = 0;
        std::size_t block = 0;
    };
    void split(std::vector<exact::Point>& sample, std::size_t begin, std::size_t end, std::size_t first,
               std::size_t blocks);

    std::vector<Node> nodes_;
};

}  // namespace votess::blocks
