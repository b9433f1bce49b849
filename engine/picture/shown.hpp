// Which cells a picture shows, and where they are.
#pragma once

#include <algorithm>
#include <vector>

#include "core/arithmetic.hpp"
#include "core/thread_pool.hpp"
#include "picture/mesh.hpp"

namespace votess::picture {

struct Shown {
    std::vector<char> cells;  // 1: shown
    bool walls_hidden = false;
    Box bounds;  // of the cells shown; of the domain when walls are shown
};

[[nodiscard]] Shown choose_cells(const Mesh& mesh, const Box& domain, WallCells wall_cells, ThreadPool& pool);

inline constexpr std::size_t block_cells = 2048;
// Runs task(begin, end, block) over blocks of the cells.
template <class Task>
void over_cells(std::size_t cells, ThreadPool& pool, const Task& task) {
    pool.run(ceil_div(cells, block_cells), [&](std::size_t block, unsigned) {
        task(block * block_cells, std::min(cells, (block + 1) * block_cells), block);
    });
}

}  // namespace votess::picture
