// Rows of text, parsed by threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <vector>

#include "failure.hpp"
#include "in_order.hpp"
#include "read/input.hpp"

namespace clvotess {

// Appends rows to `input`, from pieces of whole lines. Stops before a piece that has an error, or more rows than may
// follow: the reader goes on from there, row by row. Small texts are left to the reader. Reader: lines() returns its
// LineReader, and append_rows(input) appends all rows of its text; the first row has been read.
template <class Reader>
void append_by_threads(Reader& reader, Input& input, std::size_t max_rows, unsigned threads) {
    constexpr std::size_t piece_bytes = std::size_t{1} << 20;
    std::string_view rest = reader.lines().rest();
    if (threads == 1 || rest.size() < 2 * piece_bytes) return;
    std::vector<std::string_view> texts;
    for (; !rest.empty(); rest.remove_prefix(texts.back().size()))
        texts.push_back(rest.substr(0, std::min(rest.find('\n', piece_bytes), rest.size() - 1) + 1));
    struct Piece {
        Input rows;
        std::size_t bytes = 0, lines = 0;
        bool good = true;
    };
    const Reader start(reader);
    in_order(
        texts.size(), threads,
        [&](std::size_t k) {
            Piece piece;
            Reader part(start);
            part.lines().go_on(texts[k]);
            try {
                part.append_rows(piece.rows);
            } catch (const Failure&) {
                piece.good = false;  // the line number is known only to the reader
            }
            piece.bytes = texts[k].size();
            piece.lines = part.lines().line() - start.lines().line();
            return piece;
        },
        [&](const Piece& piece) {
            if (!piece.good || piece.rows.size() > max_rows - input.size()) return false;
            input.append(piece.rows);
            reader.lines().skip(piece.bytes, piece.lines);
            return true;
        });
}

}  // namespace clvotess
