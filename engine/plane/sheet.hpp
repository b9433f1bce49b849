// Two dimensions: the cells of points of the plane are those of a thin sheet between two walls, seen from above. Each
// is a prism over a polygon. The walls lie at z = -h and z = h, where h is a power of two. So areas and lengths are the
// volumes and areas of the sheet divided by 2h, without rounding: the measures that its result holds, see MeasureUnit.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "input/settled.hpp"
#include "plane/prism.hpp"
#include "result/result.hpp"
#include "votess/votess.hpp"

namespace votess {

// Adds what a sheet needs for the wants of the plane.
void add_sheet_wants(Want& want, bool& list_walls);
// Turns the result of a sheet, with all faces, into that of the plane. wanted, list_walls: those of the plane, with all
// that they imply.
void flatten(detail::Result& result, const Want& wanted, bool list_walls, double min_face = 0, double min_area = 0);

// Returns (N, 3) points, with z = 0. points: (N, 2), whole ones.
[[nodiscard]] inline std::vector<double> in_sheet(const Points& points) {
    std::vector<double> raised(points.coordinates() / 2 * 3);
    for (std::size_t i = 0; i < points.coordinates() / 2 * 2; ++i) raised[i / 2 * 3 + i % 2] = points[i];
    return raised;
}

// Returns (N, 2) points. points: (N, 3).
[[nodiscard]] inline std::vector<double> out_of_sheet(std::span<const double> points) {
    std::vector<double> flat(points.size() / 3 * 2);
    for (std::size_t i = 0; i < flat.size(); ++i) flat[i] = points[i / 2 * 3 + i % 2];
    return flat;
}

class Sheet {
public:
    // planar: with whole points, (N, 2).
    explicit Sheet(Settled planar);
    // A sheet without points, for those that come in parts. of_points: bounds of all `count` points.
    Sheet(const Box& of_points, std::uint64_t count, Settled planar);

    // Returns the run in space, with points (N, 3) of the sheet.
    [[nodiscard]] const Settled& in_space() const { return in_space_; }
    [[nodiscard]] Settled take_in_space() { return std::move(in_space_); }
    [[nodiscard]] std::vector<double> take_points() { return std::move(points_); }
    // Returns whether a wall is that below or above all points.
    [[nodiscard]] static bool bounds(std::int32_t wall) { return wall == below || wall == above; }
    // Faces that a cell of the sheet has and the cell of the plane has not.
    static constexpr std::uint32_t more_faces = 2;
    // Turns the result of the sheet into that of the plane.
    void flatten(detail::Result& result) const {
        votess::flatten(result, wanted_, list_walls_, min_face_, min_area_);
        if (prism_) result.mesh_edges = std::make_shared<const std::vector<std::int32_t>>(prism_->names());
    }

    static constexpr std::int32_t below = -5, above = -6;

private:
    std::vector<double> points_;
    std::optional<Prism> prism_;  // of the mesh; in_space() refers to it
    Settled in_space_;
    Want wanted_;      // of the plane
    bool list_walls_;  // of the plane
    double min_face_, min_area_;
};

}  // namespace votess
