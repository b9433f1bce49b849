// Tessellates seeds that do not fit into memory: they come in pieces, wait in temporary files, are tessellated block by
// block, and rows go out in pieces, in the order of the seeds. Rows are those of one tessellate()
// with all seeds, bit for bit, whatever the memory is.
//
//     struct Seeds : votess::StreamSource { bool next(votess::StreamSeeds& some) override { ... } };
//     struct Rows : votess::StreamSink { void rows(const votess::StreamRows& some) override { ... } };
//     votess::tessellate_stream(seeds, rows, options, {.memory = 2'000'000'000});
//
// All seeds are read twice, or once into a temporary file, in which all that has to wait is written and read
// front to back. Temporary files have no names: they are gone when the call ends, and with the process, however that
// ends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "votess/votess.hpp"

namespace votess {

// Some seeds, in the order of the input. The arrays stay the source's, which must keep them until its next call.
struct StreamSeeds {
    std::span<const double> points;          // (n, 3), any number of them, as for tessellate()
    std::span<const double> weights, radii;  // n of one of these in a power diagram, each time; else none
};

class VOTESS_API StreamSource {
public:
    virtual ~StreamSource();
    // Begins with the first seed, at first and once more. False where seeds can be had only once.
    virtual bool restart() = 0;
    // The next seeds; false when there are no more.
    virtual bool next(StreamSeeds& seeds) = 0;
};

// What is known before the first row.
struct StreamHead {
    std::uint64_t seeds = 0;
    std::uint64_t entries = 0;  // of all rows; 0 where neighbors are not wanted
    bool duplicates = false;    // whether there are any
    bool periodic = false;      // whether rows have shifts
    Options options;            // of the run, with the box that was settled, without weights and radii
};

// The cells of the seeds first .. first + status.size() - 1, which follow those before. Arrays as those of
// Tessellation, but ids have 64 bits; those not wanted are empty. They are the sink's until it returns.
struct StreamRows {
    std::uint64_t first = 0;
    std::span<const CellStatus> status;                     // n
    std::span<const std::int64_t> duplicate_of;             // n where the run has duplicates
    std::span<const std::int64_t> indptr;                   // n+1, counted from the first seed on
    std::span<const std::int64_t> neighbors;                // entries
    std::span<const std::int8_t> shifts;                    // (entries, 3), where the domain is periodic
    std::span<const double> areas, normals;                 // entries, (entries, 3)
    std::span<const double> volumes, centroids;             // n, (n, 3)
    std::span<const double> surface_areas, security_radii;  // n each
    std::span<const std::uint32_t> face_counts, edge_counts, vertex_counts;  // n each
};

class VOTESS_API StreamSink {
public:
    virtual ~StreamSink();
    virtual void begin(const StreamHead& head);  // does nothing
    virtual void rows(const StreamRows& rows) = 0;
};

struct StreamOptions {
    // Bytes that the call may take, beside what source and sink take for themselves; at least least_memory. Seeds at
    // one place are in one block, so very many of them may take more.
    std::uint64_t memory = 0;
    static constexpr std::uint64_t least_memory = 1'000'000;
    // Folder of the temporary files. "": that of the environment's TMPDIR, or /tmp.
    std::string temporary;
    // Checks all rows as verify() does, while they go to the sink, which has had them all when the outcome is known.
    bool verify = false;
};

struct StreamResult {
    Options options;  // as in StreamHead
    // seconds: upload = seeds are read and go to blocks, sort = layers, clip = cells of blocks, fallback = cells that
    // ask other blocks, download = rows come together, go to the sink and are checked.
    Stats stats;
    std::uint64_t blocks = 0, largest_block = 0;  // and the seeds of that one
    std::uint64_t asked_cells = 0;                // that were completed by other blocks
    std::uint64_t temporary_bytes = 0;            // in all files
    // With StreamOptions::verify. Rows pass once, so the text on rows that are not symmetric does not name the seeds.
    // How many cells are tried against all seeds depends on the input, the number of blocks and the memory: as many as
    // take about a second, at least 64 or all.
    std::optional<VerifyReport> verified;
};

// options: weights and radii come from the source. want.vertices and want.faces, min_face, min_area, duplicates = error
// and GPUs are `unsupported`. options.log is told each stage, and how much room the temporary
// files take before the first of them is written. Errors: those of tessellate(), `storage` where a temporary file
// cannot be written or there is no room, and what source and sink throw.
VOTESS_API StreamResult tessellate_stream(StreamSource& source, StreamSink& sink, const Options& options,
                                          const StreamOptions& stream);

}  // namespace votess
