// Two dimensions: the cells of points of the plane are those of a thin sheet between two walls, seen from above. Each
// is a prism over a polygon. The walls lie at z = -h and z = h, where h is a power of two. So areas and lengths are the
// volumes and areas of the sheet divided by 2h, without rounding.
#pragma once

#include <cstdint>
#include <vector>

#include "input/job.hpp"
#include "result/result.hpp"
#include "votess/votess.hpp"

namespace votess {

// Returns the options of a sheet with walls at z = -height and height. Its box or cell is unset if `planar` has none.
// Throws invalid_argument for z in the domain.
[[nodiscard]] Options sheet_options(const Options& planar, double height);

class Sheet {
public:
    // points: (N, 2). Throws invalid_argument for z in the domain and for an odd number of coordinates.
    Sheet(const Points& points, const Options& planar);

    [[nodiscard]] Points points() const { return {points_, {}}; }  // (N, 3)
    [[nodiscard]] const Options& options() const { return options_; }
    [[nodiscard]] double thickness() const { return 2 * height_; }
    // Returns whether a wall is that below or above all points.
    [[nodiscard]] static bool bounds(std::int32_t wall) { return wall == below || wall == above; }
    // Turns the result of the sheet into that of the plane.
    void flatten(detail::Result& result) const;

private:
    void flatten_rows(detail::Result& result) const;

    static constexpr std::int32_t below = -5, above = -6;

    std::vector<double> points_;
    Options options_;
    Want wanted_;      // of the plane
    bool list_walls_;  // of the plane
    double height_ = 1;
};

}  // namespace votess
