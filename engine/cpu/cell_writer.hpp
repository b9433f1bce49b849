// Puts finished cells where results go: rows in the order of the engine, block by block, and what has a fixed place at
// once. One per thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpu/cell.hpp"
#include "cpu/sorted_seeds.hpp"
#include "cpu/star.hpp"
#include "cpu/star_kernels.hpp"
#include "result_builder.hpp"

namespace votess::cpu {

class CellWriter {
public:
    explicit CellWriter(const SortedSeeds& seeds) : seeds_(seeds) {}

    void begin_job(const Job& job, const StarKernels& kernels, ResultBuilder& out);
    // For the start of a cell: its results go to the places of the input, which are anywhere in memory.
    void prefetch(std::size_t seed) const;
    // The last cell that `star` has built; false when its geometry cannot be had to the digits promised.
    [[nodiscard]] bool write(std::size_t seed, Star& star);
    void write(std::size_t seed, Cell& cell);
    // The row of the next cell comes by another block.
    void leave_out() { lengths_.push_back(0); }
    // Hands the rows written since the last call to the result; cells: as in ResultBuilder::add_rows.
    void end_block(std::span<const std::int32_t> cells);

    [[nodiscard]] const CellCounters& counters() const { return counters_; }

private:
    [[nodiscard]] bool need_geometry() const { return want_.volumes || want_.centroids || want_.areas; }
    void write_empty(std::size_t seed);
    void write_geometry(std::size_t seed, double volume, const double* centroid);
    void write_counts(std::size_t seed, std::size_t faces, std::uint32_t edges, std::uint32_t vertices);
    [[nodiscard]] std::int32_t input_of(std::int32_t id) const;
    void rank_images(std::span<const std::int32_t> ids);
    // ids: sorted seeds or walls, any number; areas: beside them, or null.
    void write_row(std::span<const std::int32_t> ids, const double* areas);

    const SortedSeeds& seeds_;
    const StarKernels* kernels_ = nullptr;
    ResultBuilder* out_ = nullptr;
    Want want_;
    bool walls_ = false;
    double unscale_ = 1;
    CellCounters counters_;
    std::size_t rows_size_ = 0;
    std::vector<std::int32_t> rows_;  // filled up to rows_size_
    std::vector<double> areas_;
    std::vector<std::uint32_t> lengths_;
    Star::Geometry geometry_;
    CellFaces faces_;
    std::vector<std::int32_t> ids_, planes_;
    std::vector<double> face_areas_, kept_areas_;
    std::vector<std::uint16_t> places_, order_;
};

}  // namespace votess::cpu
