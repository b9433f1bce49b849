// Polygons of a plane, laid over each other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/vector3.hpp"

namespace votess::solid {

// Takes the edges of polygons in layers. Cuts the plane into trapezoids, and counts how often the polygons of each
// layer wind around them. Rounding moves the trapezoids' sides, but leaves no gaps.
class Layers {
public:
    static constexpr std::size_t max_layers = 4;
    using Counts = std::array<int, max_layers>;

    // Begins a plane with an outward unit normal. Returns the quotient of an area and its projection along an axis.
    double begin(const Vector3& normal);
    // Returns the axes across which it is projected.
    [[nodiscard]] std::size_t x() const { return x_; }
    [[nodiscard]] std::size_t y() const { return y_; }
    // Adds an edge `weight` times. Polygons seen from outside are counterclockwise.
    void add(const Vector3& from, const Vector3& to, std::size_t layer, int weight);

    // Visits each trapezoid with its area and counts.
    template <class Visit>
    void for_each_part(Visit visit) {
        prepare();
        for (std::size_t k = 0; k + 1 < cuts_.size(); ++k) {
            const double left = cuts_[k], right = cuts_[k + 1];
            find_active(left, right);
            Counts counts{};
            for (std::size_t i = 0; i + 1 < active_.size(); ++i) {
                for (std::size_t layer = 0; layer < max_layers; ++layer) counts[layer] += active_[i].edge->step[layer];
                const double height = 0.5 * (active_[i + 1].twice_middle - active_[i].twice_middle);
                if (height > 0) visit((right - left) * height * stretch_, counts);
            }
        }
    }

private:
    struct Edge {  // from left to right; the counts above it are larger by `step`
        double x0, y0, x1, y1;
        Counts step;

        [[nodiscard]] double at(double x) const { return x == x1 ? y1 : y0 + (x - x0) / (x1 - x0) * (y1 - y0); }
    };
    struct Active {
        double twice_middle;  // height between two cuts
        const Edge* edge;
    };
    void prepare();
    void find_active(double left, double right);

    std::size_t x_ = 0, y_ = 1;
    double stretch_ = 1;  // an area over that of its projection
    std::vector<Edge> edges_;
    std::vector<double> cuts_;
    std::vector<Active> active_;
};

}  // namespace votess::solid
