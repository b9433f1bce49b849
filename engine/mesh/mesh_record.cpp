#include "mesh/mesh_record.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>

#include "core/ceil.hpp"

namespace votess {
namespace {

constexpr std::size_t alignment = 8;
constexpr std::size_t least_bytes = std::size_t{1} << 16;

template <class T>
std::byte* put(std::byte* to, std::span<const T> values) {
    if (!values.empty()) std::memcpy(to, values.data(), values.size_bytes());
    return to + values.size_bytes();
}

template <class T>
std::byte* put_numbers(std::byte* to, std::span<const std::uint32_t> values) {
    for (const std::uint32_t value : values) {
        const auto number = static_cast<T>(value);
        std::memcpy(to, &number, sizeof number);
        to += sizeof number;
    }
    return to;
}

}  // namespace

void MeshBlock::append(const MeshCell& cell) {
    constexpr std::size_t most_narrow = std::numeric_limits<std::uint16_t>::max();
    MeshCellView::Head head;
    head.vertices = static_cast<std::uint32_t>(cell.positions.size() / 3);
    head.faces = static_cast<std::uint32_t>(cell.ends.size());
    head.hidden = static_cast<std::uint32_t>(cell.hidden);
    head.corners = static_cast<std::uint32_t>(cell.corners.size());
    head.wide = cell.corners.size() > most_narrow || head.vertices > most_narrow || cell.labels.size() > most_narrow;
    head.origin = cell.origin;
    const std::size_t number_size = head.wide != 0 ? sizeof(std::uint32_t) : sizeof(std::uint16_t);
    const std::size_t size = sizeof head + cell.positions.size_bytes() + cell.labels.size_bytes() +
                             (2 * cell.ends.size() + cell.corners.size()) * number_size;
    begins_.push_back(used_);
    const std::size_t end = used_ + round_up(size, alignment);
    if (end > bytes_.size()) bytes_.resize(2 * end + least_bytes);
    std::byte* to = bytes_.data() + used_;
    used_ = end;
    vertices_ += head.vertices;
    to = put(to, std::span<const MeshCellView::Head>(&head, 1));
    to = put(to, cell.positions);
    to = put(to, cell.labels);
    for (const auto list : {cell.beginnings, cell.ends, cell.corners})
        to = head.wide != 0 ? put_numbers<std::uint32_t>(to, list) : put_numbers<std::uint16_t>(to, list);
}

MeshCellView::MeshCellView(const std::byte* record) {
    if (record == nullptr) return;
    std::memcpy(&head_, record, sizeof head_);
    record += sizeof head_;
    positions_ = reinterpret_cast<const double*>(record);
    record += sizeof(double) * 3 * head_.vertices;
    labels_ = reinterpret_cast<const FaceLabel*>(record);
    record += sizeof(FaceLabel) * (std::size_t{head_.hidden} + head_.faces);
    narrow_ = reinterpret_cast<const std::uint16_t*>(record);
    wide_ = reinterpret_cast<const std::uint32_t*>(record);
}

void MeshCellView::set_first(std::byte* record, std::uint32_t first) {
    std::memcpy(record + offsetof(Head, first), &first, sizeof first);
}

std::size_t MeshCellView::find(const FaceLabel& wanted) const {
    const FaceLabel* const begin = labels_ + head_.hidden;
    const FaceLabel* const end = begin + head_.faces;
    const FaceLabel* const at = std::lower_bound(begin, end, wanted);
    return at != end && *at == wanted ? static_cast<std::size_t>(at - begin) : head_.faces;
}

}  // namespace votess
