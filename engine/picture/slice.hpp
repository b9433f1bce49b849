// A plane section of the cells, seen along its axis.
#pragma once

#include <span>

#include "picture/legend/layout.hpp"
#include "picture/mesh.hpp"
#include "picture/shown.hpp"

namespace votess::picture {

struct SliceJob {
    const Mesh& mesh;
    const Shown& shown;
    std::span<const double> points;
    std::span<const Color> colors;  // of the cells
    const PictureOptions& options;
    std::span<const Vec3> periods;  // vectors by which the cells repeat
    Area area;                      // at most; the section keeps its shape
};

// Adds the polygons, the seeds and the frame; returns the area that they take.
Area build_slice(const SliceJob& job, const Sizes& sizes, ThreadPool& pool, Scene& scene);

}  // namespace votess::picture
