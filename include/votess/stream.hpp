// Tessellates seeds that do not fit into memory. They arrive in pieces and wait in temporary files. Each block of them
// is tessellated by itself, and rows leave in pieces, in input order. Rows are bit for bit those of one tessellate()
// with all seeds, for any memory limit. Of fewer than 30 seeds in a domain without end, last digits of sizes may
// differ.
//
//     struct Seeds : votess::StreamSource { bool next(votess::StreamSeeds& some) override { ... } };
//     struct Rows : votess::StreamSink { void rows(const votess::StreamRows& some) override { ... } };
//     votess::tessellate_stream(seeds, rows, options, {.memory = 2'000'000'000});
//
// The seeds are read twice, or once into a temporary file. Temporary files are written and read front to back. They
// have no names, so they vanish when the call or the process ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "votess/row_arrays.hpp"

namespace votess {

// Some seeds, in input order. The source keeps the arrays until its next call.
struct StreamSeeds {
    std::span<const double> points;          // (n, 3), in the plane (n, 2), any n, as for tessellate()
    std::span<const double> weights, radii;  // in a power diagram n of one of these, each time; else none
};

class VOTESS_API StreamSource {
public:
    virtual ~StreamSource();
    // Goes back to the first seed; called first and once more. Returns false if the seeds can be read only once.
    virtual bool restart() = 0;
    // Writes the next seeds. Returns false when there are no more.
    virtual bool next(StreamSeeds& seeds) = 0;
};

// Known before the first row.
struct StreamHead {
    std::uint64_t seeds = 0;
    std::uint64_t entries = 0;  // of all rows; 0 when neighbors were not requested
    bool duplicates = false;    // whether there are any
    bool periodic = false;      // whether rows have shifts
    Options options;            // of the run, with the box that was used, without weights and radii
};

// The cells of the seeds first .. first + n - 1; pieces follow each other. Offsets count from the first seed of the
// run. duplicate_of is there in a run with duplicates. All arrays are valid until the sink returns.
struct StreamRows : RowArrays<detail::ConstSpan> {
    std::uint64_t first = 0;
};
// Views the cells of a rank as rows from seed 0 on. The arrays stay with the cells.
[[nodiscard]] inline StreamRows rows_of(const RowArrays<detail::Vector>& cells) {
    StreamRows rows;
    rows.indptr = cells.indptr;
    for_row_arrays([&](const auto& array, std::size_t) { array.of(rows) = array.of(cells); });
    return rows;
}

class VOTESS_API StreamSink {
public:
    virtual ~StreamSink();
    virtual void begin(const StreamHead& head);  // does nothing
    virtual void rows(const StreamRows& rows) = 0;
};

struct StreamOptions {
    // Bytes that the call may use, without those of source and sink; at least least_memory. Seeds at one place share a
    // block, so very many of them may need more.
    std::uint64_t memory = 0;
    static constexpr std::uint64_t least_memory = 1'000'000;
    // Folder of the temporary files. "": that of the environment's TMPDIR, or /tmp; on Windows the user's.
    std::string temporary;
    // Checks all rows as verify() does, on their way to the sink. The verdict arrives after the last row.
    bool verify = false;
    // The domain is the convex hull of all seeds. The first reading finds the walls of hull_walls(); the options have
    // no domain then. Memory also holds the corners of the hull, and all seeds where these lie in one plane.
    bool hull = false;
};

struct StreamResult {
    Options options;  // as in StreamHead
    // Its seconds: upload = reading seeds and sorting them into blocks, sort = layers, clip = cells of blocks, fallback
    // = cells that ask other blocks, download = collecting rows, the sink and the checks.
    Stats stats;
    std::uint64_t blocks = 0, largest_block = 0;  // number of blocks; seeds of the largest
    std::uint64_t asked_cells = 0;                // cells that other blocks completed
    std::uint64_t temporary_bytes = 0;            // of all temporary files at one time, at most
    // Set with StreamOptions::verify. A sum of 128 bits over all entries tests symmetry. It misses a fault with a
    // probability of about 2^-128, and its message does not name the seeds. Then all cells are proven, block by block.
    // In a domain without end a sample is tried instead, and in the plane too, for its numbers: as many cells as take
    // about a second, but at least 64 or all. Its size depends on the input, the number of blocks and the memory.
    // Without neighbors only volumes and Euler's formula are checked.
    std::optional<VerifyReport> verified;
};

// Tessellates the seeds of source and gives their rows to sink. Weights and radii come from the source, not from
// options. options.log receives each stage, and the disk space of the temporary files before the first is written.
// Throws `unsupported` for want.vertices, want.faces, min_face, min_area, duplicates = error, meshes and GPUs, and in a
// domain without end for a cell that weights leave empty near the seeds. There memory also holds the cells that reach
// infinity, and their neighbors. Throws `storage`
// where a temporary file cannot be written or the disk is full. Else Error as tessellate(), and exceptions of source
// and sink.
VOTESS_API StreamResult tessellate_stream(StreamSource& source, StreamSink& sink, const Options& options,
                                          const StreamOptions& stream);

}  // namespace votess
