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
// A run that cannot hold all blocks at once takes it apart: asked() is what finish_asked() needs once there are
// answers, and Responder answers for a block from those of its seeds that mark_near() finds.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cpu/cpu_clipper.hpp"
#include "distributed/blocks/blocks.hpp"
#include "distributed/blocks/outline.hpp"
#include "domain/probe.hpp"
#include "input/job.hpp"
#include "input/seeds.hpp"
#include "result/result.hpp"

namespace votess::blocks {

// A cell as it is, for a block that may cut it further.
struct Questions {
    struct Cell {
        cpu::Probe seed;  // times the scale of the job
        double reach;     // no seed cuts the cell from farther away
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

// Marks tiles whose seeds may cut a cell of the questions.
void mark_near(const Outline& outline, const Nearness& nearness, const Questions& questions, std::vector<bool>& near);

// Seeds at hand, and what votess made of them; the first ones have cells.
struct Run {
    Seeds seeds;
    std::vector<std::int32_t> row_order;  // see Job
    Job job;
    cpu::CpuClipper clipper;
    std::vector<double> powers;  // see CpuClipper::clip_first()
    detail::Result result;

    // options: of the whole run, with its box and without weights. Sorts the seeds, and makes them fit to be searched.
    void prepare(const Options& options);
    // And finds the cells of the first ones.
    void clip(const Options& options, std::size_t first);
    // Then: no seed of at most that weight cuts the cell from farther away.
    [[nodiscard]] double reach_of(std::size_t cell, double heaviest) const;
};

// Cells that had to ask, and seeds among which are all neighbors that they will keep of what they had.
struct Asked {
    Seeds cells, friends;
    std::uint64_t faces = 0;  // that the cells had before they asked
};
// The complete cells: the first ones of the run, in the order of asked.cells.
void finish_asked(const Options& options, const Asked& asked, const Seeds& answers, Run& run);

// Answers for a block.
class Responder {
public:
    Responder(const Options& options, Run& run) : options_(options), run_(run) {}
    [[nodiscard]] Seeds answer(const Questions& questions) const;

private:
    class Worker;
    const Options& options_;
    Run& run_;  // prepared
};

class LocalBlock {
public:
    // options: of the whole run, with its box and without weights, and with a callback for the progress of clip();
    // `own` ascends by id. Rows have the walls if the options list them. tiled: what another LocalBlock made of the
    // same seeds, else made anew.
    LocalBlock(const Options& options, Seeds own, std::optional<TiledSeeds> tiled = {});
    ~LocalBlock();

    [[nodiscard]] const TiledSeeds& tiled() const { return tiled_; }
    [[nodiscard]] const Outline& outline() const { return tiled_.outline; }
    [[nodiscard]] Seeds layer_for(const Outline& other) const;
    // others: of all blocks, this one's at `number`. given: the layers from others.
    void clip(std::vector<Outline> others, std::size_t number, Seeds given);
    // By block.
    [[nodiscard]] const std::vector<Questions>& questions() const { return questions_; }
    [[nodiscard]] Seeds answer(const Questions& questions);
    [[nodiscard]] BlockCells finish(const Seeds& answers);
    // After clip(): the cells as they are, of which those that ask are not complete; and these, ascending.
    [[nodiscard]] Run& run() { return all_; }
    [[nodiscard]] std::span<const std::uint32_t> asking() const { return asked_; }
    [[nodiscard]] Asked asked() const;
    [[nodiscard]] const BlockCounts& counts() const { return counts_; }

private:
    struct Unknown {  // where a block has seeds that this one does not know
        Box box;
        std::uint32_t block;
        double largest_weight;
        double from_tile;  // its distance from that of the cells, squared
    };
    class Asker;

    void ask();
    [[nodiscard]] std::vector<Unknown> unknown_near(std::size_t tile, double reach) const;
    [[nodiscard]] double weight_of(std::size_t cell) const;
    [[nodiscard]] double longest_reach(double heaviest) const;
    [[nodiscard]] bool any_near(std::size_t tile, double reach) const;
    [[nodiscard]] cpu::Probe probe_of(std::size_t cell) const;

    Options options_;
    std::size_t count_;  // own seeds
    Run all_;            // the own seeds, then those that others gave
    Job job_;            // of the own seeds
    Nearness nearness_;
    std::vector<exact::Point> places_;
    TiledSeeds tiled_;
    std::vector<Outline> outlines_;
    std::size_t number_ = 0;
    std::vector<std::int32_t> positions_;  // of the own seeds among the sorted ones; -1: none
    std::vector<std::uint32_t> asked_;     // own cells, ascending
    std::vector<std::int32_t> friends_;    // neighbors of these, as they are: places in all_.seeds
    std::uint64_t asked_faces_ = 0;        // of these
    std::vector<Questions> questions_;
    BlockCounts counts_;
};

}  // namespace votess::blocks
