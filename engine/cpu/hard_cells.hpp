// Hard cells, which a search proves only after very many tests. They belong to seeds near a common sphere and on hulls
// of clusters in a void. Their search is given up. After all other cells it continues with more and more tests
// (CpuClipper::clip_hard()), or one triangulation of all seeds finds the neighbors, whichever is cheaper. In a periodic
// domain they may be hard since they reach images that are not among the seeds, as those of a line of seeds do. Then
// the cells are first made again among more images.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>

namespace votess::cpu {

// Limits the cost of the cells of a block. When many are hard, later ones are hardly tried. Each block has its own
// budget, so that hard cells do not depend on threads.
class SearchBudget {
public:
    static constexpr std::size_t max_tests = 2000;  // for one cell
    static constexpr std::size_t free_tests = 128;  // not counted
    static constexpr std::size_t tests_per_cell = 8, min_cells = 256;
    static constexpr std::size_t long_streak = 8;

    void begin(std::size_t cells) {
        left_ = tests_per_cell * std::max(cells, min_cells);
        streak_ = 0;
    }
    // Whether to try the cell as a star. The longer the streak of hard cells, the less often.
    [[nodiscard]] bool worth_a_star() const { return streak_ < long_streak || std::has_single_bit(streak_); }
    // Returns the tests that the cell may take.
    [[nodiscard]] std::size_t tests() const { return left_ > 0 ? max_tests : 0; }

    void star_done() { streak_ = 0; }
    void searched(std::size_t tests, bool found) {
        left_ -= std::min(left_, tests - std::min(tests, free_tests));
        streak_ = found ? 0 : streak_ + 1;
    }

private:
    std::size_t left_ = 0, streak_ = 0;
};

}  // namespace votess::cpu
