// The summary of a run, for people or as JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

#include "domain.hpp"
#include "read/input.hpp"
#include "read/surface.hpp"

namespace clvotess {

// Further counts of a run over ranks.
struct RanksSummary {
    int ranks = 1;
    unsigned rounds = 0;                                   // exchanges of seeds
    std::uint64_t ghosts_received = 0, ghosts_needed = 0;  // seeds received from other ranks; those that are neighbors
};

// Further counts of a run over frames.
struct FramesSummary {
    std::uint64_t count = 0, first = 0, last = 0;  // numbers of the first and last frame
    std::uint64_t min_points = 0, max_points = 0;  // in a frame
    bool moving_domain = false;                    // whether the domain differs between them
};

struct Summary {
    votess::Stats stats;
    std::string domain, domain_json;
    std::string mesh;             // the file of --mesh; may be empty
    std::uint64_t triangles = 0;  // of the mesh, or edges
    const char* mesh_parts = "triangles";
    std::optional<const char*> plane_from;  // in two dimensions: "option" or "assumed"
    bool has_volumes = false;
    std::string input_note;  // the part of the file that was read, such as a frame; may be empty
    double seconds_total = 0, seconds_read = 0, seconds_write = 0;  // the other stages are in stats
    std::optional<votess::VerifyReport> verified;                   // with --verify
    std::optional<RanksSummary> ranks;
    struct Fit {
        unsigned steps = 0;
        double residual = 0;  // largest |volume - target| / target
    };
    std::optional<Fit> fit;  // with --volumes
    struct Streamed {
        std::uint64_t blocks = 0, largest_block = 0, asked_cells = 0, temporary_bytes = 0;
    };
    std::optional<Streamed> streamed;     // with --memory
    std::optional<FramesSummary> frames;  // with --frames; the other numbers are sums

    // Adds the numbers of a frame, or takes those of the only one.
    void add(const Summary& one, std::uint64_t number, std::uint64_t points);
    void set_mesh(const std::string& file, const Surface& surface);
    void set_domain(const votess::Tessellation& tessellation, const DomainFrom& from);
    void set_dimensions(bool planar, Dimensions requested);
    // Returns why no file was written; empty on success.
    [[nodiscard]] std::string failure() const;
};

// Returns a text as JSON, in quotes.
[[nodiscard]] std::string json_string(const std::string& text);
[[nodiscard]] std::string plain_summary(const Summary& summary);
[[nodiscard]] std::string json_summary(const Summary& summary);  // one line

}  // namespace clvotess
