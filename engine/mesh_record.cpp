#include "mesh_record.hpp"

#include <cstring>
#include <limits>

namespace votess {
namespace {

constexpr std::size_t alignment = 8;

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
    MeshCellView::Head head;
    head.vertices = static_cast<std::uint32_t>(cell.positions.size() / 3);
    head.faces = static_cast<std::uint32_t>(cell.ends.size());
    head.corners = static_cast<std::uint32_t>(cell.corners.size());
    head.wide = head.corners > std::numeric_limits<std::uint16_t>::max() ||
                head.vertices > std::numeric_limits<std::uint16_t>::max();
    head.origin = cell.origin;
    const std::size_t numbers = cell.ends.size() + cell.corners.size();
    const std::size_t size = sizeof head + cell.positions.size_bytes() + cell.beginnings.size_bytes() +
                             numbers * (head.wide != 0 ? sizeof(std::uint32_t) : sizeof(std::uint16_t));
    const std::size_t begin = bytes_.size();
    begins_.push_back(begin);
    bytes_.resize(begin + (size + alignment - 1) / alignment * alignment);
    std::byte* to = bytes_.data() + begin;
    to = put(to, std::span<const MeshCellView::Head>(&head, 1));
    to = put(to, cell.positions);
    to = put(to, cell.beginnings);
    for (const auto list : {cell.ends, cell.corners})
        to = head.wide != 0 ? put_numbers<std::uint32_t>(to, list) : put_numbers<std::uint16_t>(to, list);
}

MeshCellView::MeshCellView(const std::byte* record) {
    if (record == nullptr) return;
    std::memcpy(&head_, record, sizeof head_);
    record += sizeof head_;
    positions_ = reinterpret_cast<const double*>(record);
    record += sizeof(double) * 3 * head_.vertices;
    beginnings_ = reinterpret_cast<const FaceLabel*>(record);
    record += sizeof(FaceLabel) * head_.faces;
    narrow_ = reinterpret_cast<const std::uint16_t*>(record);
    wide_ = reinterpret_cast<const std::uint32_t*>(record);
}

}  // namespace votess
