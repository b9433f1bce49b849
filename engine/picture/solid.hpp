// The cells in three dimensions, cut open.
#pragma once

#include <span>
#include <vector>

#include "picture/mesh.hpp"
#include "picture/shown.hpp"

namespace votess::picture {

// A rectangle of the picture, in pixels.
struct Area {
    double left = 0, top = 0, right = 0, bottom = 0;
};

struct SolidJob {
    const Mesh& mesh;
    const Shown& shown;
    std::span<const double> points;
    std::span<const Color> colors;  // of the cells
    const PictureOptions& options;
    Area area;         // to fill
    bool own_outline;  // cells reach beyond the bounds, or do not fill them
    bool whole_cells;  // all cuts remove whole cells
};

// Adds the view, the triangles and the domain's edges. `corners` holds the domain's eight corners, bit a of the index
// telling its end along edge a; empty: no frame.
void build_solid(const SolidJob& job, std::span<const Vec3> corners, ThreadPool& pool, Scene& scene);

// Adds a polygon as a fan of triangles; less than three corners add nothing.
void add_fan(const Polygon& polygon, const Vec3& normal, Color color, std::vector<FillVertex>& out);

// Lines around pieces are strokes: a piece may have triangles thinner than a line.
inline constexpr Color line_color = rgb(45, 45, 55);
// Returns the width for a piece that reaches so many pixels from its middle: lines fade where pieces are as small as
// they. line: the full width.
[[nodiscard]] double line_width(double size, double line);
// Appends lists that blocks of cells made, and frees them.
template <class T>
void append(std::vector<std::vector<T>>& blocks, std::vector<T>& to) {
    for (std::vector<T>& block : blocks) {
        to.insert(to.end(), block.begin(), block.end());
        block = {};
    }
}
// Leaves one of the lines that two pieces share.
void remove_repeats(std::vector<Stroke>& lines);

// The domain as the picture needs it.
struct DomainShape {
    Box box;                    // its bounds
    std::vector<Vec3> corners;  // as in build_solid
    std::vector<Vec3> periods;  // vectors by which the cells repeat
    bool of_pieces = false;     // the bounds of pieces, which cuts remove as a whole
};

// All of a picture but the drawing. values: what the cells are colored by.
[[nodiscard]] Scene build_scene(const Mesh& mesh, const DomainShape& domain, std::span<const double> points,
                                std::span<const double> values, const PictureOptions& options, ThreadPool& pool);

}  // namespace votess::picture
