#include "output/polygon_writer.hpp"

#include <algorithm>

namespace votess::cpu {
namespace {

constexpr std::uint32_t none = ~std::uint32_t{0};

}  // namespace

void PolygonWriter::append(const CellPolygons& polygons, std::span<const FaceLabel> labels,
                           std::span<const std::uint32_t> order, std::size_t hidden,
                           const std::array<double, 3>& origin) {
    const std::size_t faces = order.size(), listed = faces - hidden;
    hidden_labels_.resize(hidden);
    for (std::size_t r = 0; r < hidden; ++r) hidden_labels_[r] = labels[order[r]];
    const auto& shared = polygons.shared;
    if (!shared.empty()) {
        const std::size_t largest = *std::ranges::max_element(shared);
        if (largest >= in_block_.size()) in_block_.resize(2 * largest + 1, none);
    }
    const auto place_of = [&](std::uint32_t vertex) {
        std::uint32_t own = none;
        std::uint32_t& place = shared.empty() ? own : in_block_[shared[vertex]];
        if (place == none) {
            const auto& x = polygons.positions[vertex];
            place = block_.add_vertex({origin[0] + x[0], origin[1] + x[1], origin[2] + x[2]});
        }
        return place;
    };
    number_.assign(polygons.positions.size(), none);
    vertices_.resize(polygons.positions.size());
    first_across_.resize(listed);
    ends_.resize(listed);
    corners_.resize(polygons.corners.size());
    std::uint32_t vertices = 0, corners = 0;
    for (std::size_t r = 0; r < faces; ++r) {
        const std::uint32_t begun = corners, end = polygons.offsets[order[r] + 1];
        for (std::uint32_t k = polygons.offsets[order[r]]; k < end; ++k) {
            const std::uint32_t vertex = polygons.corners[k];
            std::uint32_t number = number_[vertex];
            if (number == none) {
                number_[vertex] = number = vertices;
                vertices_[vertices++] = place_of(vertex);
            }
            corners_[corners++] = number;
        }
        if (r < hidden) {
            corners = begun;
            continue;
        }
        first_across_[r - hidden] = polygons.first_across[order[r]];
        ends_[r - hidden] = corners;
    }
    block_.append({origin, shared.empty() ? 0 : group_, std::span(vertices_).first(vertices), hidden_labels_,
                   first_across_, ends_, std::span(corners_).first(corners)});
}

}  // namespace votess::cpu
