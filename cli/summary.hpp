// What a run tells at its end, for people or as JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>
#include <votess/votess.hpp>

namespace clvotess {

// What a run over ranks says beside the rest.
struct RanksSummary {
    int ranks = 1;
    unsigned rounds = 0;                                   // exchanges of seeds
    std::uint64_t ghosts_received = 0, ghosts_needed = 0;  // seeds that ranks were given by others; of these, neighbors
};

struct Summary {
    votess::Stats stats;
    std::string domain, domain_json;
    bool has_volumes = false;
    std::string input_note;  // what was taken out of the file; empty when there is nothing to say
    double seconds_total = 0, seconds_read = 0, seconds_write = 0;  // the stages between are in stats
    std::optional<votess::VerifyReport> verified;                   // nothing when not asked
    std::optional<RanksSummary> ranks;
    struct Streamed {
        std::uint64_t blocks = 0, largest_block = 0, asked_cells = 0, temporary_bytes = 0;
    };
    std::optional<Streamed> streamed;  // with --memory

    // Why no file was written; empty where nothing is wrong.
    [[nodiscard]] std::string failure() const;
};

[[nodiscard]] std::string plain_summary(const Summary& summary);
[[nodiscard]] std::string json_summary(const Summary& summary);  // one line

}  // namespace clvotess
