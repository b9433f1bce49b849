// Layers of polygons, laid over each other without rounding.
#pragma once

#include <cstddef>
#include <vector>

#include "exact/integer/big_int.hpp"
#include "solid/layers.hpp"

namespace votess::solid {

// As Layers, for corners whose coordinates are fractions. Decides which parts exist at all.
class ExactLayers {
public:
    // The place (x / w, y / w); w is positive.
    struct Corner {
        exact::BigInt x, y, w;
    };
    void begin() { edges_.clear(); }
    void add(const Corner& from, const Corner& to, std::size_t layer, int weight);

    // Visits each trapezoid of positive area. Its area is rounded, and at least the smallest double.
    template <class Visit>
    void for_each_part(int quantum, Visit visit) {
        prepare();
        for (std::size_t k = 0; k + 1 < cuts_.size(); ++k) {
            find_active(k);
            Layers::Counts counts{};
            for (std::size_t i = 0; i + 1 < active_.size(); ++i) {
                for (std::size_t layer = 0; layer < Layers::max_layers; ++layer)
                    counts[layer] += active_[i].edge->step[layer];
                if (counts == Layers::Counts{} || !(active_[i].middle < active_[i + 1].middle)) continue;
                visit(area(k, i, quantum), counts);
            }
        }
    }

private:
    struct Edge {               // from left to right; the counts above it are larger by `step`
        exact::BigInt a, b, c;  // a x + b y + c = 0 on it; b is positive
        exact::Fraction x0, x1;
        Layers::Counts step;
        std::size_t first = 0, last = 0;  // cuts at its ends
    };
    struct Active {
        exact::Fraction middle;  // height between two cuts
        const Edge* edge;
    };
    void prepare();
    void find_active(std::size_t cut);
    [[nodiscard]] double area(std::size_t cut, std::size_t active, int quantum) const;

    std::vector<Edge> edges_;
    std::vector<exact::Fraction> cuts_;
    std::vector<Active> active_;
};

}  // namespace votess::solid
