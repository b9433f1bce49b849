#include "cpu/clip/polygon_writer.hpp"

namespace votess::cpu {

void PolygonWriter::append(const CellPolygons& polygons, std::span<const FaceLabel> labels,
                           std::span<const std::uint32_t> order, std::size_t hidden,
                           const std::array<double, 3>& origin) {
    constexpr std::uint32_t none = ~std::uint32_t{0};
    const std::size_t faces = order.size(), listed = faces - hidden;
    rank_.resize(faces);
    labels_.resize(faces);
    for (std::size_t r = 0; r < faces; ++r) {
        rank_[order[r]] = static_cast<std::uint32_t>(r);
        labels_[r] = labels[order[r]];
    }
    number_.assign(polygons.positions.size(), none);
    positions_.resize(3 * polygons.positions.size());
    beginnings_.resize(listed);
    ends_.resize(listed);
    corners_.resize(polygons.corners.size());
    std::uint32_t vertices = 0, corners = 0;
    for (std::size_t r = 0; r < faces; ++r) {
        const std::uint32_t begin = polygons.offsets[order[r]], end = polygons.offsets[order[r] + 1];
        std::uint32_t first = begin, least = none;
        for (std::uint32_t k = begin; k < end; ++k)
            if (const std::uint32_t beside = rank_[polygons.beside[k]]; beside < least) first = k, least = beside;
        const std::uint32_t begun = corners;
        const auto take = [&](std::uint32_t from, std::uint32_t to) {
            for (std::uint32_t k = from; k < to; ++k) {
                std::uint32_t& number = number_[polygons.corners[k]];
                if (number == none) {
                    const auto& x = polygons.positions[polygons.corners[k]];
                    for (std::size_t axis = 0; axis < 3; ++axis) positions_[3 * std::size_t{vertices} + axis] = x[axis];
                    number = vertices++;
                }
                corners_[corners++] = number;
            }
        };
        take(first, end);
        take(begin, first);
        if (r < hidden) {
            corners = begun;
            continue;
        }
        beginnings_[r - hidden] = least;
        ends_[r - hidden] = corners;
    }
    block_.append({origin, std::span(positions_).first(3 * std::size_t{vertices}), labels_, hidden, beginnings_, ends_,
                   std::span(corners_).first(corners)});
}

}  // namespace votess::cpu
