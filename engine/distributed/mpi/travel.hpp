// Seeds on their way to blocks, and cells on their way back.
#pragma once

#include <vector>

#include "core/bytes.hpp"
#include "votess/blocks.hpp"

namespace votess::mpi {

template <class T>
Message to_bytes(const std::vector<T>& values) {
    const auto bytes = std::as_bytes(std::span(values));
    return {bytes.begin(), bytes.end()};
}
template <class T>
void append_bytes(const Message& message, std::vector<T>& values) {
    const std::size_t old = values.size();
    values.resize(old + message.size() / sizeof(T));
    if (!message.empty()) std::memcpy(values.data() + old, message.data(), message.size());
}

struct Handed {
    std::vector<std::int64_t> ids;
    std::vector<double> points, weights;
    std::vector<std::int32_t> owners;  // by whom; not in messages

    [[nodiscard]] Message to_message() const;
    // Joins those of all ranks, ascending by id.
    static Handed of(const std::vector<Message>& from);
};

// The cells of a block at these places.
Message pack(const std::vector<std::int64_t>& ids, const BlockCells& cells, const std::vector<std::size_t>& places);
// The cells of the rank's own block, at the places of those that it handed in itself: they need no message.
struct OwnCells {
    std::vector<std::int64_t> ids;
    BlockCells cells;
    std::vector<std::size_t> places;
};
// Those of all blocks, in the order of ids. status: of seeds that were left out, `outside`.
BlockCells unpack(const std::vector<Message>& from, const std::vector<std::int64_t>& ids,
                  const std::vector<CellStatus>& status, OwnCells own);

}  // namespace votess::mpi
