// Messages between blocks.
#pragma once

#include <utility>
#include <vector>

#include "core/bytes.hpp"
#include "distributed/blocks/far_cells.hpp"

namespace votess::blocks {

// A halo with the tiles of the block that sends it.
inline Message to_message(const Seeds& halo, const Outline& outline) {
    return halo.size() == 0 ? Message{} : message_of(outline.tiles, halo);
}
// Keeps the outline when the message is empty.
inline void read_halo(const Message& message, Seeds& halo, Outline& outline) {
    if (message.empty()) return;
    std::vector<Tile> tiles;
    read_message(message, tiles, halo);
    outline = outline_of(std::move(tiles));
}
inline Outline read_outline(const Message& message) {
    std::vector<Tile> tiles;
    read_message(message, tiles);
    return outline_of(std::move(tiles));
}
// Joins what messages hold: Seeds or FarCells.
template <class T>
T joined(const std::vector<Message>& messages) {
    T all;
    for (const Message& message : messages) {
        T some;
        read_message(message, some);
        all.add(some);
    }
    return all;
}

}  // namespace votess::blocks
