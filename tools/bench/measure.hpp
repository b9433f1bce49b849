// Contestants that take turns, their measurements, and the reports.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "bench.hpp"

namespace bench {

struct Contestant {
    const Peer* peer;
    const Input* input;
    Want want;
    unsigned threads;
};

// How often a contestant runs, in seconds of its own.
struct Repeats {
    int count = 5;
    double at_least = 0;   // seconds in all before which repeats go on: quick runs are measured often
    double patience = 30;  // seconds in all after which repeats end: slow runs are measured less often
    double limit = 120;    // seconds of one run above which a contestant is skipped
};

// One line of the report: a contestant after its runs.
struct Measurement {
    std::string input;
    std::size_t n = 0;
    Want want = Want::neighbors;
    std::string peer;
    bool bounded = true;
    unsigned threads = 1;
    std::vector<double> seconds;  // each repeat; empty: failed or left out
    Answer answer;                // of the last repeat
    double box_volume = 0, volume_error = 0;
    std::optional<std::uint64_t> expected_links;
    std::vector<votess::StageSeconds> stages;  // each repeat, of votess
    std::string note;                          // why there is no time

    [[nodiscard]] double seconds_per_cell() const;  // of the median
};

bool same_task(const Measurement& a, const Measurement& b);
double median(std::vector<double> values);

// Remembers how slow each contestant was on smaller inputs.
class Timekeeper {
public:
    // One measurement a contestant, in their order.
    std::vector<Measurement> measure(const std::vector<Contestant>& contestants, const Repeats& repeats);

private:
    std::map<std::string, double> paces_;  // the slowest so far, seconds per point
};

// Compares each result with the first votess of the group on the same input. Prints differences to stderr and returns
// their number.
int check(const std::vector<Measurement>& group);

// The fields of StageSeconds but the total, in their order.
struct Stage {
    const char* name;
    double votess::StageSeconds::*seconds;
};
inline constexpr Stage stages[] = {
    {"open", &votess::StageSeconds::open},        {"upload", &votess::StageSeconds::upload},
    {"sort", &votess::StageSeconds::sort},        {"knn", &votess::StageSeconds::knn},
    {"clip", &votess::StageSeconds::clip},        {"fallback", &votess::StageSeconds::fallback},
    {"download", &votess::StageSeconds::download}};
double median_of(const Stage& stage, const std::vector<votess::StageSeconds>& runs);

struct PeerVersion {
    std::string name, version;
};
void print_table(const std::vector<Measurement>& group);
// A line for each input, size and want: how many times as fast as each peer votess is on one thread.
void print_ratios(const std::vector<Measurement>& measurements);
std::string short_number(std::size_t n);  // 1e5 for 100000

// A list of objects in the JSON file.
struct Section {
    std::string name;
    std::vector<std::string> items;
};
Section section_of(const std::vector<Measurement>& measurements);
// {"upload": [seconds of each run], ...}
std::string stages_json(const std::vector<votess::StageSeconds>& runs);
// Written whole or not at all. Throws std::runtime_error.
void write_json(const std::string& file, const std::vector<PeerVersion>& peers, const std::vector<Section>& sections);

}  // namespace bench
