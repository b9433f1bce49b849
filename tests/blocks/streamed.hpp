// A run of tessellate_stream() as a whole result, to compare.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>
#include <votess/stream.hpp>

#include "distributed/blocks/blocks.hpp"

namespace test {

// Arrays in pieces of so many seeds. once: they do not begin again.
class Pieces : public votess::StreamSource {
public:
    Pieces(std::span<const double> points, const votess::Options& options, std::size_t piece, bool once = false)
        : points_(points), weights_(options.weights), radii_(options.radii), piece_(piece), once_(once) {}
    bool restart() override;
    bool next(votess::StreamSeeds& seeds) override;

private:
    std::span<const double> points_, weights_, radii_;
    std::size_t piece_, at_ = 0;
    bool once_;
};

// Puts rows one after the other.
struct StreamedRows : votess::StreamSink {
    void begin(const votess::StreamHead& said) override { head = said; }
    void rows(const votess::StreamRows& some) override;

    votess::StreamHead head;
    votess::BlockCells cells;  // without tags
    std::size_t pieces = 0;
    std::string wrong;  // how a piece does not follow the one before
};

struct Streamed {
    StreamedRows rows;
    votess::StreamResult result;
};
// piece: of source and once more of it; how many seeds at once.
Streamed streamed(std::span<const double> points, const votess::Options& options, std::uint64_t memory,
                  std::size_t piece = 777, bool once = false, bool verify = false);

// "" when these are the arrays of t, bit for bit.
std::string difference(const Streamed& found, const votess::Tessellation& t);

}  // namespace test
