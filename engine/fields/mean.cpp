// The field that is constant in each cell: the polygons of the cells are bodies, of the volumes that the result states.
#include <cmath>

#include "fields/methods.hpp"
#include "fields/overlay.hpp"

namespace votess::fields {
namespace {

// Of a triangle of a piece.
struct Base {
    std::size_t seed = 0, first_vertex = 0;
};

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

// The pieces of cells: tetrahedra from the first vertex of a piece over its triangles, with their signs.
class PiecesOfCells final : public Carrier {
public:
    PiecesOfCells(const Task& task, const Pieces& pieces, std::span<const Base> bases)
        : pieces_(pieces),
          bases_(bases),
          values_(task.values),
          columns_(task.columns),
          frame_(task.frame),
          grid_(task.grid) {}

    bool load(std::size_t number, Body& body) override {
        const Base& base = bases_[number];
        const double* const apex = vertex(base, 0);
        const std::int32_t* const corner = &pieces_.triangles[3 * number];
        std::array<Vector, 4> x{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (corner[k] == 0) return false;
            x[k + 1] = frame_.difference(apex, vertex(base, corner[k]));
        }
        const double volume = dot(x[1], cross(x[2], x[3])) / 6;
        if (volume == 0) return false;
        if (volume < 0) std::swap(x[2], x[3]);
        seed_ = base.seed;
        volume_ = frame_.mirrored() ? -volume : volume;
        body.place.at = frame_.position(apex);
        body.piece.clear();
        for (const auto& [a, b, c] : {std::array{1, 2, 3}, {0, 2, 1}, {0, 3, 2}, {0, 1, 3}})
            body.piece.add_polygon(std::array{x[static_cast<std::size_t>(a)], x[static_cast<std::size_t>(b)],
                                              x[static_cast<std::size_t>(c)]});
        return true;
    }

    void add(std::size_t cell, const ConvexPiece::Measure& part) override {
        const double volume = part.volume * volume_;
        for (std::size_t c = 0; c < columns_; ++c) grid_[cell * columns_ + c] += volume * values_[seed_ * columns_ + c];
    }

private:
    [[nodiscard]] const double* vertex(const Base& base, std::int32_t number) const {
        return &pieces_.vertices[3 * (base.first_vertex + static_cast<std::size_t>(number))];
    }

    const Pieces& pieces_;
    std::span<const Base> bases_;
    std::span<const double> values_;
    std::size_t columns_;
    const Frame& frame_;
    std::span<double> grid_;
    // Of the tetrahedron loaded last.
    std::size_t seed_ = 0;
    double volume_ = 0;  // in grid cells
};

}  // namespace

void add_mean(const Task& task, const Pieces& pieces, ThreadPool& pool) {
    std::vector<Base> bases(pieces.on_surface.size());
    for (std::size_t seed = 0; seed + 1 < pieces.indptr.size(); ++seed)
        for (auto p = static_cast<std::size_t>(pieces.indptr[seed]);
             p < static_cast<std::size_t>(pieces.indptr[seed + 1]); ++p)
            for (std::int64_t t = pieces.triangle_offsets[p]; t < pieces.triangle_offsets[p + 1]; ++t)
                bases[static_cast<std::size_t>(t)] = {seed, static_cast<std::size_t>(pieces.vertex_offsets[p])};
    overlay(task.frame, pool, bases.size(), [&] { return std::make_unique<PiecesOfCells>(task, pieces, bases); });
}

void add_mean(const Task& task, const Built& built, ThreadPool& pool) {
    overlay(task.frame, pool, built.tessellation.size(),
            [&] { return std::make_unique<Cells>(task, built.tessellation); });
}

}  // namespace votess::fields
