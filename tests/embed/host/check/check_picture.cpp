#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "check/check.hpp"

namespace host {
namespace {

using Vector = std::array<double, 3>;

constexpr double tolerance = 1e-4;  // of lengths along a ray, in a picture drawn in float32

constexpr std::uint32_t unknown = 0xffffffff;  // the pixel of a box in which no cell is certified

double dot(const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector from_eye(const DrawPush& view, double across, double down) {
    Vector direction{};
    for (std::size_t a = 0; a < 3; ++a) {
        direction[a] = view.forward[a] + view.eye[3] * (across * view.right[a] - down * view.up[a]);
    }
    const double length = std::sqrt(dot(direction, direction));
    for (double& x : direction) x /= length;
    return direction;
}

// A part of a ray.
struct Interval {
    double begin = 0, end = std::numeric_limits<double>::infinity();
    // Cuts off what lies beyond a plane: where slope * t > offset.
    void clip(double slope, double offset) {
        if (slope > 0) end = std::min(end, offset / slope);
        if (slope < 0) begin = std::max(begin, offset / slope);
        if (slope == 0 && offset < 0) end = -std::numeric_limits<double>::infinity();
    }
    [[nodiscard]] double length() const { return end - begin; }
};

// The seeds and their whole cells.
class Scene {
public:
    Scene(const DrawPush& view, std::span<const float> seeds, const Results& results)
        : view_(view), results_(results), points_(seeds.size() / 4) {
        std::vector<double> packed;
        for (std::size_t i = 0; i < points_.size(); ++i) {
            points_[i] = {seeds[4 * i], seeds[4 * i + 1], seeds[4 * i + 2]};
            packed.insert(packed.end(), points_[i].begin(), points_[i].end());
        }
        votess::Options options;
        options.device = "cpu";
        options.box = votess::Box{{0, 0, 0}, {1, 1, 1}};
        cells_ = votess::tessellate(packed, options);
    }

    [[nodiscard]] bool certified(std::size_t i) const {
        return results_.cells[i].status == static_cast<std::uint32_t>(votess::CellStatus::certified);
    }
    [[nodiscard]] bool solid(std::size_t i) const {
        const Vector& p = points_[i];
        const bool beyond = p[0] > view_.cut[0] && p[1] < view_.cut[1] && p[2] > view_.cut[2];
        return !certified(i) || !(beyond || results_.geometry[4 * i + 3] > view_.cut[3]);
    }
    // Where the ray from the eye is inside the cell.
    [[nodiscard]] Interval inside(std::size_t i, const Vector& direction) const {
        const Vector eye{view_.eye[0], view_.eye[1], view_.eye[2]};
        Interval interval;
        for (std::size_t a = 0; a < 3; ++a) {
            interval.clip(direction[a], 1 - eye[a]);
            interval.clip(-direction[a], eye[a]);
        }
        if (cells_.status()[i] != votess::CellStatus::certified) return {0, -1};
        const Vector& p = points_[i];
        for (const std::int32_t j : cells_.neighbors(i)) {
            const Vector& q = points_[static_cast<std::size_t>(j)];
            const Vector normal{q[0] - p[0], q[1] - p[1], q[2] - p[2]};
            const Vector middle{(p[0] + q[0]) / 2 - eye[0], (p[1] + q[1]) / 2 - eye[1], (p[2] + q[2]) / 2 - eye[2]};
            interval.clip(dot(normal, direction), dot(normal, middle));
            if (interval.length() < -1) break;
        }
        return interval;
    }
    [[nodiscard]] std::size_t size() const { return points_.size(); }

private:
    const DrawPush& view_;
    const Results& results_;
    std::vector<Vector> points_;
    votess::Tessellation cells_;
};

}  // namespace

std::string compare_picture(const DrawPush& view, std::uint32_t width, std::span<const float> seeds,
                            const Results& results, std::span<const std::uint32_t> seen) {
    const Scene scene(view, seeds, results);
    // So many pixels, spread over the picture, that the time stays in bounds.
    const std::size_t most = std::max<std::size_t>(100, 10'000'000 / std::max<std::size_t>(1, scene.size()));
    const std::size_t step = seen.size() / std::min(most, seen.size());
    std::size_t looked_at = 0, doubtful = 0, of_cells = 0;
    for (std::size_t pixel = 0; pixel < seen.size(); pixel += step) {
        const double x = static_cast<double>(pixel % width) + 0.5, y = static_cast<double>(pixel / width) + 0.5;
        const Vector direction = from_eye(view, 2 * x / view.height - view.right[3], 2 * y / view.height - 1);
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < scene.size(); ++i) {
            if (!scene.solid(i)) continue;
            const Interval interval = scene.inside(i, direction);
            if (interval.length() > tolerance) nearest = std::min(nearest, interval.begin);
        }
        // Where no cell is certified there is nothing to follow a ray through.
        if (seen[pixel] == unknown && results.header.certified == 0 && !std::isinf(nearest)) {
            ++looked_at;
            ++of_cells;
            continue;
        }
        const bool background = seen[pixel] == 0;
        const std::size_t cell = seen[pixel] - std::size_t{1};
        bool right = background && std::isinf(nearest);
        if (!background && cell < scene.size()) {
            const Interval interval = scene.inside(cell, direction);
            right = scene.solid(cell) && interval.length() > -tolerance && interval.begin < nearest + tolerance;
        }
        ++looked_at;
        if (!background) ++of_cells;
        if (right) continue;
        // Behind cells without rows a walk to the first cell of a ray may end too early; it must end in one, then.
        if (cell < scene.size() && !scene.certified(cell) && ++doubtful <= looked_at / 50 + 2) continue;
        std::ostringstream text;
        text << "pixel " << x << ' ' << y << " shows " << (background ? "none" : std::to_string(cell))
             << "; the first solid cell is at distance " << nearest;
        return text.str();
    }
    // A picture in which all of this is true of background alone would show nothing.
    if (of_cells < looked_at / 10) return "hardly a cell is seen";
    return "";
}

}  // namespace host
