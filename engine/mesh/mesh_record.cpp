#include "mesh/mesh_record.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <limits>

#include "core/arithmetic.hpp"

namespace votess {
namespace {

constexpr std::size_t alignment = 8;
constexpr std::size_t min_bytes = std::size_t{1} << 16;

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
    head.origin = cell.origin;
    head.vertices = static_cast<std::uint32_t>(cell.vertices.size());
    head.faces = static_cast<std::uint32_t>(cell.ends.size());
    head.hidden = static_cast<std::uint32_t>(cell.hidden.size());
    head.corners = static_cast<std::uint32_t>(cell.corners.size());
    head.group = cell.group;
    head.first = static_cast<std::uint32_t>(vertices_.size());
    vertices_.insert(vertices_.end(), cell.vertices.begin(), cell.vertices.end());
    const std::size_t largest =
        std::max({cell.corners.size(), cell.vertices.size(), cell.hidden.size() + cell.ends.size()});
    head.number_size = largest <= std::numeric_limits<std::uint8_t>::max()    ? 1
                       : largest <= std::numeric_limits<std::uint16_t>::max() ? 2
                                                                              : 4;
    const std::size_t size =
        sizeof head + cell.hidden.size_bytes() + (2 * cell.ends.size() + cell.corners.size()) * head.number_size;
    begins_.push_back(used_);
    const std::size_t end = used_ + round_up(size, alignment);
    if (end > bytes_.size()) bytes_.resize(2 * end + min_bytes);
    std::byte* to = bytes_.data() + used_;
    used_ = end;
    to = put(to, std::span<const MeshCellView::Head>(&head, 1));
    to = put(to, cell.hidden);
    for (const auto list : {cell.first_across, cell.ends, cell.corners})
        to = head.number_size == 1   ? put_numbers<std::uint8_t>(to, list)
             : head.number_size == 2 ? put_numbers<std::uint16_t>(to, list)
                                     : put_numbers<std::uint32_t>(to, list);
}

MeshCellView::MeshCellView(const std::byte* record) {
    if (record == nullptr) return;
    std::memcpy(&head_, record, sizeof head_);
    record += sizeof head_;
    labels_ = reinterpret_cast<const FaceLabel*>(record);
    numbers_ = record + sizeof(FaceLabel) * head_.hidden;
}

void MeshCellView::set_block(std::byte* record, std::uint32_t block) {
    std::memcpy(record + offsetof(Head, block), &block, sizeof block);
}

bool MeshCellView::share(const MeshCellView& a, const std::byte* b) {
    if (b == nullptr || a.head_.group == 0) return false;
    std::uint32_t block, group;
    std::memcpy(&block, b + offsetof(Head, block), sizeof block);
    std::memcpy(&group, b + offsetof(Head, group), sizeof group);
    return block == a.head_.block && group == a.head_.group;
}

}  // namespace votess
