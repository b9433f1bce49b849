// Some of the seeds of a run, and the cells that they have among all of them: what stands behind votess::Block.
//
// If j is a neighbor of i among all seeds, it is one among any that contain both: their common face can only be larger
// there. So the neighbors of i are among those that it has in {i} and each block (Levy, arXiv
// 2406.04192, 2024). A block clips its cells with its own seeds and the layers that others gave it. A cell that
// reaches seeds which the block was not given asks their blocks: each clips the same cell further, from the faces that
// it has, by its own seeds, and answers with those that are left. With all answers at hand the cell is complete. One
// question is enough: a smaller cell reaches nothing that the larger one did not.
//
// No block knows how another one is reached. In the order of use:
//   layer_for() each other outline; clip() with all that others gave; questions(); answer() those of others; finish()
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "blocks/outline.hpp"
#include "blocks/seeds.hpp"
#include "cpu/cpu_clipper.hpp"
#include "cpu/probe.hpp"
#include "input/job.hpp"
#include "result/result.hpp"
#include "votess/blocks.hpp"

namespace votess::blocks {

// A cell as it is, for a block that may cut it further.
struct Questions {
    struct Cell {
        cpu::Probe seed;  // times the scale of the job
        std::uint64_t guards;
    };
    // A neighbor that it has: the plane between them, relative to the seed.
    struct Guard {
        exact::Point q;
        exact::Shift shift;
        exact::DoubleDouble power;
    };
    std::vector<Cell> cells;
    std::vector<Guard> guards;  // of all cells, one after the other
};

class LocalBlock {
public:
    // options: of the whole run, with its box and without weights; `own` ascends by id. Rows have the walls if the
    // options list them.
    LocalBlock(const Options& options, Seeds own);
    ~LocalBlock();

    [[nodiscard]] const Outline& outline() const { return tiled_.outline; }
    [[nodiscard]] Seeds layer_for(const Outline& other) const;
    // others: of all blocks, this one's at `number`. given: the layers from others.
    void clip(std::vector<Outline> others, std::size_t number, Seeds given);
    // By block.
    [[nodiscard]] const std::vector<Questions>& questions() const { return questions_; }
    [[nodiscard]] Seeds answer(const Questions& questions);
    [[nodiscard]] BlockCells finish(const Seeds& answers);
    [[nodiscard]] const BlockCounts& counts() const { return counts_; }

private:
    // Seeds at hand, and what votess made of them; the first ones have cells.
    struct Run {
        Seeds seeds;
        std::vector<std::int32_t> row_order;
        Job job;
        cpu::CpuClipper clipper;
        std::vector<double> powers;  // see CpuClipper::clip_first()
        detail::Result result;
    };
    struct Unknown {  // where a block has seeds that this one does not know
        Box box;
        std::uint32_t block;
        double largest_weight;
    };
    class Asker;
    class Answerer;

    void run(Run& run, Seeds seeds, std::size_t first);
    void ask();
    [[nodiscard]] std::vector<Unknown> unknown_near(std::size_t tile, double reach) const;
    [[nodiscard]] double power_of(std::size_t cell) const;
    [[nodiscard]] double weight_of(std::size_t cell) const;
    [[nodiscard]] double reach_of(std::size_t cell, double heaviest) const;
    [[nodiscard]] cpu::Probe probe_of(std::size_t cell) const;

    Options options_;
    Seeds own_;
    Job job_;  // of the own seeds
    Nearness nearness_;
    std::vector<exact::Point> places_;
    TiledSeeds tiled_;
    std::vector<Outline> outlines_;
    std::size_t number_ = 0;
    Run all_, asked_run_;
    std::vector<std::int32_t> positions_;  // of the own seeds among the sorted ones; -1: none
    std::vector<std::uint32_t> asked_;     // own cells, ascending
    std::vector<std::int32_t> friends_;    // neighbors of these, as they are: places in all_.seeds
    std::vector<Questions> questions_;
    BlockCounts counts_;
};

}  // namespace votess::blocks
