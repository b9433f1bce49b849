// What blocks say, as bytes.
#pragma once

#include "core/bytes.hpp"
#include "distributed/blocks/local_block.hpp"

namespace votess::blocks {

// A layer, and the tiles of the block that gives it.
inline Message to_message(const Seeds& layer, const Outline& outline) {
    if (layer.size() == 0) return {};
    Writer writer;
    writer.put(outline.tiles);
    layer.put_to(writer);
    return writer.take();
}
inline Message to_message(const Outline& outline) {
    if (outline.tiles.empty()) return {};
    Writer writer;
    writer.put(outline.tiles);
    return writer.take();
}
inline Message to_message(const Questions& questions) {
    if (questions.cells.empty()) return {};
    Writer writer;
    writer.put(questions.cells);
    writer.put(questions.guards);
    return writer.take();
}

// Leaves the outline where there is no layer.
inline void from_message(const Message& message, Seeds& layer, Outline& outline) {
    if (message.empty()) return;
    Reader reader(message);
    std::vector<Tile> tiles;
    reader.get(tiles);
    layer.get_from(reader);
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
inline void from_message(const Message& message, Questions& questions) {
    if (message.empty()) return;
    Reader reader(message);
    reader.get(questions.cells);
    reader.get(questions.guards);
    reader.end();
}

}  // namespace votess::blocks
