#include "cpu/clip/polygon_writer.hpp"

namespace votess::cpu {

void PolygonWriter::append(const CellPolygons& polygons, std::span<const FaceLabel> labels,
                           std::span<const std::uint32_t> order, std::size_t hidden,
                           const std::array<double, 3>& origin) {
    constexpr std::uint32_t none = ~std::uint32_t{0};
    positions_.clear();
    labels_.clear();
    beginnings_.clear();
    ends_.clear();
    corners_.clear();
    rank_.resize(order.size());
    for (std::size_t r = 0; r < order.size(); ++r) {
        rank_[order[r]] = static_cast<std::uint32_t>(r);
        labels_.push_back(labels[order[r]]);
    }
    number_.assign(polygons.positions.size(), none);
    for (std::size_t r = 0; r < order.size(); ++r) {
        const std::uint32_t begin = polygons.offsets[order[r]], end = polygons.offsets[order[r] + 1];
        std::uint32_t first = begin;
        for (std::uint32_t k = begin; k < end; ++k)
            if (rank_[polygons.beside[k]] < rank_[polygons.beside[first]]) first = k;
        for (std::uint32_t k = first, left = end - begin; left > 0; --left, k = k + 1 == end ? begin : k + 1) {
            const std::uint32_t vertex = polygons.corners[k];
            if (number_[vertex] == none) {
                number_[vertex] = static_cast<std::uint32_t>(positions_.size() / 3);
                for (const double x : polygons.positions[vertex]) positions_.push_back(x);
            }
            if (r >= hidden) corners_.push_back(number_[vertex]);
        }
        if (r < hidden) continue;
        beginnings_.push_back(rank_[polygons.beside[first]]);
        ends_.push_back(static_cast<std::uint32_t>(corners_.size()));
    }
    block_.append({origin, positions_, labels_, hidden, beginnings_, ends_, corners_});
}

}  // namespace votess::cpu
