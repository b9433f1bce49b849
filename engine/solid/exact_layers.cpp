#include "solid/exact_layers.hpp"

#include <algorithm>
#include <limits>

#include "core/progress.hpp"

namespace votess::solid {

using exact::BigInt;
using exact::Fraction;
using exact::Quad;

void ExactLayers::add(const Corner& from, const Corner& to, std::size_t layer, int weight) {
    const BigInt across = from.w * to.x - from.x * to.w;
    if (across.sign() == 0) return;  // upright
    const bool forward = across.sign() > 0;
    const Corner &left = forward ? from : to, &right = forward ? to : from;
    Edge edge{left.y * right.w - left.w * right.y,
              forward ? across : -across,
              left.x * right.y - left.y * right.x,
              {left.x, left.w},
              {right.x, right.w},
              {}};
    edge.step[layer] = forward ? weight : -weight;
    edges_.push_back(std::move(edge));
}

// Cuts the plane at all ends and crossings.
void ExactLayers::prepare() {
    cuts_.clear();
    std::ranges::sort(edges_, [](const Edge& e, const Edge& f) { return e.x0 < f.x0; });
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        check_stop();
        const Edge& e = edges_[i];
        cuts_.insert(cuts_.end(), {e.x0, e.x1});
        for (std::size_t j = i + 1; j < edges_.size() && edges_[j].x0 < e.x1; ++j) {
            const Edge& f = edges_[j];
            const BigInt turn = e.a * f.b - f.a * e.b;
            if (turn.sign() == 0) continue;
            const Fraction x(e.b * f.c - f.b * e.c, turn);
            if (e.x0 < x && x < e.x1 && f.x0 < x && x < f.x1) cuts_.push_back(x);
        }
    }
    std::ranges::sort(cuts_, [](const Fraction& x, const Fraction& y) { return x < y; });
    cuts_.erase(std::unique(cuts_.begin(), cuts_.end()), cuts_.end());
    const auto cut = [&](const Fraction& x) {
        const auto at = std::ranges::lower_bound(cuts_, x, [](const Fraction& y, const Fraction& z) { return y < z; });
        return static_cast<std::size_t>(at - cuts_.begin());
    };
    for (Edge& edge : edges_) edge.first = cut(edge.x0), edge.last = cut(edge.x1);
}

// Finds the edges between a cut and the next, from the lowest up.
void ExactLayers::find_active(std::size_t cut) {
    check_stop();
    active_.clear();
    const Fraction twice = cuts_[cut] + cuts_[cut + 1];
    const BigInt middle = twice.numerator, scale = twice.denominator + twice.denominator;
    for (const Edge& edge : edges_)
        if (edge.first <= cut && edge.last > cut)
            active_.push_back({{-(edge.a * middle + edge.c * scale), edge.b * scale}, &edge});
    std::ranges::sort(active_, [](const Active& e, const Active& f) { return e.middle < f.middle; });
}

double ExactLayers::area(std::size_t cut, std::size_t active, int quantum) const {
    const Fraction width = cuts_[cut + 1] - cuts_[cut], height = active_[active + 1].middle - active_[active].middle;
    const auto rounded = static_cast<double>(ldexp(static_cast<Quad>(width) * static_cast<Quad>(height), 2 * quantum));
    return std::max(rounded, std::numeric_limits<double>::denorm_min());
}

}  // namespace votess::solid
