// Writes finished cells: rows block by block in the order of the engine, values of fixed size at once to their places.
// One for each thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/buffer.hpp"
#include "follow/kept_cells.hpp"
#include "follow/kept_planes.hpp"
#include "index/seed_images.hpp"
#include "index/sorted_seeds.hpp"
#include "kernels/star_kernels.hpp"
#include "output/near_rows.hpp"
#include "output/polygon_writer.hpp"
#include "output/result_builder.hpp"
#include "polytope/cell.hpp"
#include "walk/star.hpp"

namespace votess::cpu {

class CellWriter {
public:
    explicit CellWriter(const SortedSeeds& seeds) : seeds_(seeds), kept_planes_(seeds) {}

    // row_places: of each sorted seed in Job::row_order; or empty.
    void begin_job(const Job& job, const StarKernels& kernels, std::span<const std::int32_t> row_places,
                   ResultBuilder& out);
    // When `star` begins another stretch.
    void begin_stretch() { polygon_writer_.begin_stretch(); }
    // Prefetches the places of a cell's values, when the cell is started.
    void prefetch(std::size_t seed) const;
    // Writes the last cell that `star` built. Returns false if its geometry lacks the promised digits.
    [[nodiscard]] bool write(std::size_t seed, Star& star) {
        set_output(seed);
        return write(star);
    }
    void write(std::size_t seed, Cell& cell) {
        set_output(seed);
        write(cell);
    }
    // Writes the cell of a probe to the place `output`.
    [[nodiscard]] bool write(std::size_t output, const Probe& probe, Star& star) {
        set_output(output, probe);
        return write(star);
    }
    void write(std::size_t output, const Probe& probe, Cell& cell) {
        set_output(output, probe);
        write(cell);
    }
    // Writes the cell of a seed to the place `output`.
    void write(std::size_t output, std::size_t seed, Cell& cell) {
        set_output(seed);
        output_ = output;
        moved_ = seeds_.images != nullptr && seeds_.images->any_moved();
        write(cell);
    }
    void write_none(std::size_t output, CellStatus status);
    // After ResultBuilder::settle(): rows of the following cells go to their places at end_placing(). places: of
    // kept cells.
    void begin_placing(const SeedPlace* places) {
        placing_ = true;
        kept_planes_.begin_job(*domain_, places);
    }
    void end_placing();
    // Writes a kept cell of a seed, with its row or only with the values of faces. Returns false if its geometry lacks
    // the promised digits.
    [[nodiscard]] bool write(std::size_t seed, const KeptCell& cell, bool with_row);
    // Stores the last cell that `star` built, without writing it.
    void store(std::size_t seed, Star& star);
    // Stores the following cells of seeds there, as this worker of it. Null: nowhere.
    void keep(KeptCells* to, unsigned worker) {
        kept_ = to;
        worker_ = worker;
        ranked_ |= to != nullptr;
    }
    // Skips a cell whose row is in another block.
    void skip_row();
    // Stores the rows since the last call. They stay in the cache until then if they are few.
    static constexpr std::size_t few_rows = 4096;
    void end_rows(std::span<const std::int32_t> cells);
    [[nodiscard]] std::size_t rows() const { return written_; }
    // Stores the remaining rows of a block, and the mesh of all its cells. cells: as in ResultBuilder::add_rows.
    void end_block(std::span<const std::int32_t> cells);

    [[nodiscard]] const CellCounters& counters() const { return counters_; }
    [[nodiscard]] const FaceTally& tally() const { return tally_; }

private:
    static constexpr std::size_t max_marked = 64;   // ids of a row in which some may be equal
    static constexpr std::size_t max_ranked = 256;  // ids of a row; ranking takes the square of their number

    void set_output(std::size_t seed) {
        const std::int32_t input = seeds_.input[seed];
        output_ = static_cast<std::size_t>(only_ == nullptr ? input : only_->row_of(input));
        seed_ = seed;
        probe_ = nullptr;
    }
    void set_output(std::size_t output, const Probe& probe);
    struct Rows {
        NearWriter near;
        std::vector<std::uint32_t> lengths;
        std::vector<RowShift> shifts;
        std::uint32_t listed = 0;         // rows that have entries
        std::vector<std::int32_t> cells;  // of a part
        void clear() {
            near.clear();
            lengths.clear();
            shifts.clear();
            listed = 0;
            cells.clear();
        }
    };
    // Where the row of the current cell goes.
    [[nodiscard]] Rows& rows_of_cell() { return rows_[in_parts_ ? out_->part_of(output_) : 0]; }
    [[nodiscard]] bool write(Star& star);
    void write(Cell& cell);
    void write_empty() {
        if (kept_ != nullptr) kept_->store_none(seed_);
        write_none(output_, CellStatus::empty);
    }
    // Stores the cell whose faces are ranked. shape: null if the cell is too large for one.
    void store(const CellShape* shape, bool tied);
    [[nodiscard]] std::int32_t input_of(std::int32_t id) const;
    // Fills face_shifts_ if seeds have been moved.
    void find_shifts(std::span<const std::int32_t> ids);
    // In a skewed domain: makes face_shifts_, and the place of a seed, count from the domain instead of its reduced
    // cell.
    void count_from_domain(std::span<const std::int32_t> ids);
    [[nodiscard]] exact::Shift shift_in_domain(std::int32_t id) const;
    [[nodiscard]] exact::Point place() const;
    void measure(const Cell& cell);
    // Returns false where digits are missing; see vast_beyond() for those of areas.
    [[nodiscard]] bool measure_by_kernel(CellShape& shape);
    void write_measures();
    // Returns the unit of measures_.
    [[nodiscard]] MeasureUnit unit_of_cell() const;
    void write_counts(std::size_t faces, std::uint32_t edges, std::uint32_t vertices);
    // Fills names_ and ranks_ of faces: sorted seeds or walls. Their shifts are face_shifts_, or those of the ids if
    // these are empty.
    void rank_faces(std::span<const std::int32_t> ids);
    void rank_labels();
    [[nodiscard]] bool ranks_differ() const;
    [[nodiscard]] exact::Shift shift_of(std::size_t face) const;
    // Writes in the order of rank_faces(). face_normals_ is in the order of the faces.
    void write_row();
    // with_ids: else they are placed already.
    void place_row(bool with_ids);
    void write_steps(Rows& rows);
    void grow(std::size_t entries);
    void clear_rows();
    void write_polygons();

    const SortedSeeds& seeds_;
    const StarKernels* kernels_ = nullptr;
    ResultBuilder* out_ = nullptr;
    const Domain* domain_ = nullptr;
    const Subset* only_ = nullptr;
    std::int32_t probe_id_ = 0, probe_number_ = 0;  // of images of a probe: in its cell, in its row
    bool moved_ = false;                            // shifts count from the domain, not from its reduced cell
    Want want_;
    bool walls_ = false, periodic_ = false, placed_ = false, measured_ = false, ranked_ = false;
    std::span<const std::int32_t> row_places_;
    double thickness_ = 0;  // of a sheet
    MeasureUnit unit_;
    CellCounters counters_;
    FaceTally tally_;
    bool in_parts_ = false, placing_ = false;
    std::array<Rows, ResultBuilder::max_parts> rows_;  // since end_rows(): by part, or all in the first
    std::size_t written_ = 0;                          // cells since then
    std::size_t entries_ = 0, room_ = 0;               // of the rows; arrays below have room for so many
    Buffer<double> areas_, normals_;
    PolygonWriter polygon_writer_;
    KeptCells* kept_ = nullptr;
    unsigned worker_ = 0;  // of kept_
    KeptPlanes kept_planes_;
    std::vector<std::int32_t> homes_;  // of faces
    std::vector<exact::Shift> shifts_of_homes_;

    // The current cell: its place in the output, and its seed.
    std::size_t output_ = 0, seed_ = 0;
    const Probe* probe_ = nullptr;  // instead of seed_
    ShapeReader shape_reader_;
    CellShape shape_;  // of a clipped cell
    CellMeasures measures_;
    std::vector<double> many_areas_;
    std::span<const double> face_areas_;  // by rank, of measures_ or many_areas_
    CellFaces faces_;
    CellPolygons polygons_;
    std::vector<std::int32_t> ids_, planes_;
    std::vector<std::array<double, 3>> face_normals_;
    std::vector<exact::Shift> face_shifts_;     // as Tessellation::shifts()
    std::span<const std::int32_t> ranked_ids_;  // of the faces that are ranked
    bool shifted_ = false;                      // some of their shifts may not be 0
    // By face: the input index or wall, and the place among all faces of the cell, by index and shift.
    std::vector<std::int32_t> names_, keys_;
    std::vector<std::uint32_t> ranks_;
    std::size_t wall_faces_ = 0;  // of the cell; they come first
    std::size_t hidden_ = 0;      // faces that rows do not list: none, or the walls
    struct PlacedRows {
        std::vector<std::int32_t> cells, ids;
        std::vector<std::uint32_t> lengths;
        std::vector<double> areas, normals;
        std::vector<std::int8_t> shifts;
        void clear() {
            for (auto* values : {&cells, &ids}) values->clear();
            for (auto* values : {&areas, &normals}) values->clear();
            lengths.clear();
            shifts.clear();
        }
    };
    PlacedRows new_rows_, new_values_;  // ids and shifts; areas and normals
    std::vector<FaceLabel> labels_;
    std::vector<std::uint32_t> order_;
};

}  // namespace votess::cpu
