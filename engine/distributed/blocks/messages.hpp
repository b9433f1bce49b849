// Messages between blocks.
#pragma once

#include "core/bytes.hpp"
#include "distributed/blocks/far_cells.hpp"

namespace votess::blocks {

// A halo with the tiles of the block that sends it.
inline Message to_message(const Seeds& halo, const Outline& outline) {
    if (halo.size() == 0) return {};
    Writer writer;
    writer.put(outline.tiles);
    halo.put_to(writer);
    return writer.take();
}
inline Message to_message(const Outline& outline) {
    if (outline.tiles.empty()) return {};
    Writer writer;
    writer.put(outline.tiles);
    return writer.take();
}
inline Message to_message(const Requests& requests) {
    if (requests.cells.size() == 0) return {};
    Writer writer;
    requests.cells.put_to(writer);
    writer.put(requests.reaches);
    requests.neighbors.put_to(writer);
    return writer.take();
}

inline Message to_message(const FarCells& far) {
    if (far.ids.empty()) return {};
    Writer writer;
    writer.put(far.ids);
    far.seeds.put_to(writer);
    return writer.take();
}

inline void from_message(const Message& message, FarCells& far) {
    if (message.empty()) return;
    Reader reader(message);
    reader.get(far.ids);
    far.seeds.get_from(reader);
    reader.end();
}
// Keeps the outline when the message is empty.
inline void from_message(const Message& message, Seeds& halo, Outline& outline) {
    if (message.empty()) return;
    Reader reader(message);
    std::vector<Tile> tiles;
    reader.get(tiles);
    halo.get_from(reader);
    reader.end();
    outline = outline_of(std::move(tiles));
}
inline void from_message(const Message& message, Outline& outline) {
    if (!message.empty()) {
        Reader reader(message);
        reader.get(outline.tiles);
        reader.end();
    }
    outline = outline_of(std::move(outline.tiles));
}
inline void from_message(const Message& message, Requests& requests) {
    if (message.empty()) return;
    Reader reader(message);
    requests.cells.get_from(reader);
    reader.get(requests.reaches);
    requests.neighbors.get_from(reader);
    reader.end();
}

}  // namespace votess::blocks
