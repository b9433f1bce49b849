// A run of tessellate_stream(), joined to a whole result.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>
#include <votess/stream.hpp>

#include "distributed/blocks/blocks.hpp"

namespace test {

// A source that cuts arrays into pieces. once: it does not restart.
class Pieces : public votess::StreamSource {
public:
    Pieces(std::span<const double> points, const votess::Options& options, std::size_t piece, bool once = false)
        : points_(points),
          weights_(options.weights),
          radii_(options.radii),
          dimensions_(options.planar ? 2 : 3),
          piece_(piece),
          once_(once) {}
    bool restart() override;
    bool next(votess::StreamSeeds& seeds) override;

private:
    std::span<const double> points_, weights_, radii_;
    std::size_t dimensions_, piece_, at_ = 0;
    bool once_;
};

// A sink that joins the rows.
struct StreamedRows : votess::StreamSink {
    void begin(const votess::StreamHead& of_run) override { head = of_run; }
    void rows(const votess::StreamRows& some) override;

    votess::StreamHead head;
    votess::BlockCells cells;  // without tags
    std::size_t pieces = 0;
    std::string wrong;  // the first piece that does not continue the one before
};

struct Streamed {
    StreamedRows rows;
    votess::StreamResult result;
};
// piece: the number of seeds that the source gives at once.
Streamed streamed(std::span<const double> points, const votess::Options& options, std::uint64_t memory,
                  std::size_t piece = 777, bool once = false, bool verify = false, bool hull = false);

// Returns "" when the arrays are those of t, bit for bit, else the first difference.
std::string difference(const Streamed& found, const votess::Tessellation& t);

}  // namespace test
