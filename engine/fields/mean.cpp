// The field that is constant in each cell: the polygons of the cells are bodies, of the volumes that the result states.
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "fields/cell_polygons.hpp"
#include "fields/methods.hpp"
#include "fields/overlay.hpp"

namespace votess::fields {
namespace {

// Of a triangle of a piece.
struct Base {
    std::size_t seed = 0, first_vertex = 0;
    double factor = 1;  // of the volumes of the piece's tetrahedra: its own has more digits than its rounded vertices
    bool thin = false;  // in a piece so thin that signs are lost: parts add whatever their sign
};

// Returns the corners of a triangle of a piece, relative to the piece's first vertex, in grid cells. Nothing for a
// triangle at that vertex.
std::optional<std::array<Vector, 3>> corners_of(const Pieces& pieces, const Frame& frame, const Base& base,
                                                std::size_t triangle) {
    const double* const apex = &pieces.vertices[3 * base.first_vertex];
    std::array<Vector, 3> x{};
    for (std::size_t k = 0; k < 3; ++k) {
        const std::int32_t corner = pieces.triangles[3 * triangle + k];
        if (corner == 0) return {};
        x[k] = frame.difference(apex, apex + 3 * static_cast<std::size_t>(corner));
    }
    return x;
}
double tetrahedron(const std::array<Vector, 3>& x) {
    return dot(x[0], cross(x[1], x[2])) / 6;
}

// Bodies that carry the values of a seed, by their volume.
class CarrierOfSeeds : public Carrier {
public:
    void add(std::size_t cell, const ConvexPiece::Measure& part) final {
        const double volume = part.volume * volume_;
        const std::size_t columns = task_.columns;
        for (std::size_t c = 0; c < columns; ++c)
            task_.grid[cell * columns + c] += volume * task_.values[seed_ * columns + c];
    }

protected:
    explicit CarrierOfSeeds(const Task& task) : task_(task) {}

    const Task& task_;
    // The seed of the body loaded last, and its volume in grid cells.
    std::size_t seed_ = 0;
    double volume_ = 0;
};

class Cells final : public CarrierOfSeeds {
public:
    Cells(const Task& task, const Tessellation& t)
        : CarrierOfSeeds(task), t_(t), size_(task.frame.cell_size()), polygons_(t, task.frame) {}

    bool load(std::size_t seed, Body& body) override {
        if (!polygons_.load(seed)) return false;
        seed_ = seed;
        body.place.at = polygons_.at();
        body.piece.clear();
        for (std::size_t face = polygons_.begin(); face < polygons_.end(); ++face)
            body.piece.add_polygon(polygons_.polygon(face));
        volume_ = std::isnormal(t_.volumes()[seed]) ? std::ldexp(t_.volumes()[seed] / size_.mantissa, -size_.exponent)
                                                    : body.piece.volume();
        return true;
    }

private:
    // The volume of a tiny cell has more digits than the polyhedron of its rounded vertices, which only says where it
    // lies.
    const Tessellation& t_;
    Size size_;  // of a grid cell
    CellPolygons polygons_;
};

// The pieces of cells: tetrahedra from the first vertex of a piece over its triangles, with their signs.
class PiecesOfCells final : public CarrierOfSeeds {
public:
    PiecesOfCells(const Task& task, const Pieces& pieces, std::span<const Base> bases)
        : CarrierOfSeeds(task), pieces_(pieces), bases_(bases), frame_(task.frame) {}

    bool load(std::size_t number, Body& body) override {
        const Base& base = bases_[number];
        const auto corners = corners_of(pieces_, frame_, base, number);
        if (!corners) return false;
        const double volume = tetrahedron(*corners);
        if (volume == 0) return false;
        std::array x{Vector{}, (*corners)[0], (*corners)[1], (*corners)[2]};
        if (volume < 0) std::swap(x[2], x[3]);
        seed_ = base.seed;
        volume_ = (base.thin ? std::abs(volume) : frame_.mirrored() ? -volume : volume) * base.factor;
        body.place.at = frame_.position(&pieces_.vertices[3 * base.first_vertex]);
        body.piece.clear();
        for (const auto& [a, b, c] : {std::array{1, 2, 3}, {0, 2, 1}, {0, 3, 2}, {0, 1, 3}})
            body.piece.add_polygon(std::array{x[static_cast<std::size_t>(a)], x[static_cast<std::size_t>(b)],
                                              x[static_cast<std::size_t>(c)]});
        return true;
    }

private:
    const Pieces& pieces_;
    std::span<const Base> bases_;
    const Frame& frame_;
};

}  // namespace

void add_mean(const Task& task, const Pieces& pieces, ThreadPool& pool) {
    std::vector<Base> bases(pieces.on_surface.size());
    const Size size = task.frame.cell_size();
    for (std::size_t seed = 0; seed + 1 < pieces.indptr.size(); ++seed)
        for (auto p = static_cast<std::size_t>(pieces.indptr[seed]);
             p < static_cast<std::size_t>(pieces.indptr[seed + 1]); ++p) {
            Base base{seed, static_cast<std::size_t>(pieces.vertex_offsets[p])};
            const auto first = static_cast<std::size_t>(pieces.triangle_offsets[p]),
                       last = static_cast<std::size_t>(pieces.triangle_offsets[p + 1]);
            double sum = 0, all = 0;
            for (std::size_t t = first; t < last; ++t)
                if (const auto corners = corners_of(pieces, task.frame, base, t)) {
                    sum += task.frame.mirrored() ? -tetrahedron(*corners) : tetrahedron(*corners);
                    all += std::abs(tetrahedron(*corners));
                }
            const double volume = std::ldexp(pieces.volumes[p] / size.mantissa, -size.exponent);
            base.thin = !(sum > volume / 2 && sum < 2 * volume);
            base.factor = volume / (base.thin ? all : sum);
            std::fill(bases.begin() + static_cast<std::ptrdiff_t>(first),
                      bases.begin() + static_cast<std::ptrdiff_t>(last), base);
        }
    overlay(task.frame, pool, bases.size(), [&] { return std::make_unique<PiecesOfCells>(task, pieces, bases); });
}

void add_mean(const Task& task, const Built& built, ThreadPool& pool) {
    overlay(task.frame, pool, built.tessellation.size(),
            [&] { return std::make_unique<Cells>(task, built.tessellation); });
}

}  // namespace votess::fields
