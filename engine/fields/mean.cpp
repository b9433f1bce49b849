// The field that is constant in each cell: the polygons of the cells are bodies, of the volumes that the result states.
#include <cmath>

#include "fields/methods.hpp"
#include "fields/overlay.hpp"

namespace votess::fields {
namespace {

class Cells final : public Carrier {
public:
    Cells(const Task& task, const Tessellation& t)
        : t_(t),
          values_(task.values),
          columns_(task.columns),
          frame_(task.frame),
          size_(task.frame.cell_size()),
          grid_(task.grid) {}

    bool load(std::size_t seed, Body& body) override {
        if (t_.status()[seed] != CellStatus::certified) return false;
        seed_ = seed;
        const auto begin = static_cast<std::size_t>(t_.indptr()[seed]),
                   end = static_cast<std::size_t>(t_.indptr()[seed + 1]);
        const double* first = vertex(static_cast<std::size_t>(t_.face_offsets()[begin]));
        body.place.at = frame_.position(first);
        body.piece.clear();
        for (std::size_t face = begin; face < end; ++face) {
            polygon_.clear();
            for (std::int64_t k = t_.face_offsets()[face]; k < t_.face_offsets()[face + 1]; ++k)
                polygon_.push_back(frame_.difference(first, vertex(static_cast<std::size_t>(k))));
            if (frame_.mirrored()) std::ranges::reverse(polygon_);
            body.piece.add_polygon(polygon_);
        }
        volume_ = std::isnormal(t_.volumes()[seed]) ? std::ldexp(t_.volumes()[seed] / size_.mantissa, -size_.exponent)
                                                    : body.piece.volume();
        return true;
    }

    void add(std::size_t cell, const ConvexPiece::Measure& part) override {
        const double volume = part.volume * volume_;
        for (std::size_t c = 0; c < columns_; ++c) grid_[cell * columns_ + c] += volume * values_[seed_ * columns_ + c];
    }

private:
    [[nodiscard]] const double* vertex(std::size_t corner) const {
        return &t_.vertices()[3 * static_cast<std::size_t>(t_.face_vertices()[corner])];
    }

    const Tessellation& t_;
    std::span<const double> values_;
    std::size_t columns_;
    const Frame& frame_;
    Size size_;  // of a grid cell
    std::span<double> grid_;
    std::vector<Vector> polygon_;
    // The cell loaded last. The volume of a tiny one has more digits than the polyhedron of its rounded vertices, which
    // only says where it lies.
    std::size_t seed_ = 0;
    double volume_ = 0;  // in grid cells
};

}  // namespace

void add_mean(const Task& task, const Built& built, ThreadPool& pool) {
    overlay(task.frame, pool, built.tessellation.size(),
            [&] { return std::make_unique<Cells>(task, built.tessellation); });
}

}  // namespace votess::fields
