#include "solid/layers.hpp"

#include <tuple>

#include "core/progress.hpp"

namespace votess::solid {

double Layers::begin(const Vector3& normal) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k)
        if (std::abs(normal[k]) > std::abs(normal[axis])) axis = k;
    x_ = (axis + 1) % 3;
    y_ = (axis + 2) % 3;
    if (normal[axis] < 0) std::swap(x_, y_);
    stretch_ = 1 / std::abs(normal[axis]);
    edges_.clear();
    return stretch_;
}

void Layers::add(const Vector3& from, const Vector3& to, std::size_t layer, int weight) {
    const bool forward = from[x_] < to[x_];
    const Vector3 &left = forward ? from : to, &right = forward ? to : from;
    if (left[x_] == right[x_]) return;  // upright
    Edge edge{left[x_], left[y_], right[x_], right[y_], {}};
    edge.step[layer] = forward ? weight : -weight;
    edges_.push_back(edge);
}

// Unites equal edges, and cuts the plane at all ends and crossings.
void Layers::prepare() {
    const auto key = [](const Edge& e) { return std::tuple(e.x0, e.y0, e.x1, e.y1); };
    std::ranges::sort(edges_, {}, key);
    std::size_t count = 0;
    for (std::size_t begin = 0, end = 0; begin < edges_.size(); begin = end) {
        Edge edge = edges_[begin];
        for (end = begin + 1; end < edges_.size() && key(edges_[end]) == key(edge); ++end)
            for (std::size_t layer = 0; layer < max_layers; ++layer) edge.step[layer] += edges_[end].step[layer];
        if (edge.step != Counts{}) edges_[count++] = edge;
    }
    edges_.resize(count);
    cuts_.clear();
    for (std::size_t i = 0; i < count; ++i) {
        check_stop();
        const Edge& a = edges_[i];
        cuts_.insert(cuts_.end(), {a.x0, a.x1});
        for (std::size_t j = i + 1; j < count && edges_[j].x0 < a.x1; ++j) {
            const Edge& b = edges_[j];
            const double left = std::max(a.x0, b.x0), right = std::min(a.x1, b.x1);
            const double before = a.at(left) - b.at(left), after = a.at(right) - b.at(right);
            if ((before < 0) == (after < 0) || before == 0 || after == 0) continue;
            const double x = left + before / (before - after) * (right - left);
            if (x > left && x < right) cuts_.push_back(x);
        }
    }
    std::ranges::sort(cuts_);
    cuts_.erase(std::unique(cuts_.begin(), cuts_.end()), cuts_.end());
}

// Finds the edges between two cuts, from the lowest up.
void Layers::find_active(double left, double right) {
    check_stop();
    active_.clear();
    for (const Edge& edge : edges_) {
        if (edge.x0 >= right) break;
        if (edge.x1 > left) active_.push_back({edge.at(left) + edge.at(right), &edge});
    }
    std::ranges::sort(active_, {}, &Active::twice_middle);
}

}  // namespace votess::solid
