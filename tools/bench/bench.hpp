// Benchmark of votess against its peers: what an input, a peer and a measurement are.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <votess/votess.hpp>

namespace bench {

struct Input {
    std::string name;
    std::vector<double> points;  // x0 y0 z0 x1 ...
    votess::Box box;
    [[nodiscard]] std::size_t size() const { return points.size() / 3; }
};

// The inputs that make_input knows.
const std::vector<std::string>& input_names();
// About n points (a lattice takes the nearest cube); the same for the same arguments on every machine.
// Throws std::invalid_argument for an unknown name.
Input make_input(std::string_view name, std::size_t n, std::uint64_t rng_seed);

enum class Want { neighbors, full };  // full: volumes and centroids too
std::string_view name_of(Want want);

// What a peer found, so that it cannot win by computing less.
struct Answer {
    double seconds = 0;
    std::uint64_t links = 0;                            // sum of the lengths of the neighbor lists, walls left out
    double volume = 0;                                  // sum of the volumes; 0 when not computed
    std::optional<votess::Stats> stats = std::nullopt;  // of votess
};

// One program to compare. run() times the way from an array of points to neighbor lists in memory, and throws
// std::exception when the peer fails on the input. Setting up what a user would reuse and freeing are not timed.
class Peer {
public:
    virtual ~Peer() = default;
    [[nodiscard]] virtual std::string name() const = 0;
    [[nodiscard]] virtual std::string version() const = 0;
    [[nodiscard]] virtual bool can(Want want) const = 0;
    // Numbers of threads to measure with, of those asked for.
    [[nodiscard]] virtual std::vector<unsigned> threads(const std::vector<unsigned>&) const { return {1}; }
    // Whether the diagram ends at the box. Others report the unbounded diagram, which has more neighbors at the rim.
    [[nodiscard]] virtual bool bounded() const { return true; }
    // Relative error of the sum of the volumes.
    [[nodiscard]] virtual double volume_error() const { return 1e-9; }
    // Before the first run on an input, not timed: what a user would set up once.
    virtual void prepare(const Input&, Want, unsigned) const {}
    [[nodiscard]] virtual Answer run(const Input& input, Want want, unsigned threads) const = 0;
};

std::unique_ptr<Peer> make_votess();
// votess on a Vulkan device, named as in votess::Options. Throws votess::Error when the device cannot be had.
std::unique_ptr<Peer> make_votess_on(const std::string& device);
std::unique_ptr<Peer> make_voropp();
std::unique_ptr<Peer> make_qhull();
std::unique_ptr<Peer> make_cgal();

// Both directions of each pair as compressed rows, for peers that deliver pairs. A user who wants neighbor lists has
// to do this, so it is timed.
struct Rows {
    std::vector<std::int64_t> indptr;
    std::vector<std::int32_t> indices;
};
Rows rows_from_pairs(std::size_t n, const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs);

class Stopwatch {
public:
    [[nodiscard]] double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// One line of the report: a peer on an input.
struct Measurement {
    std::string input;
    std::size_t n = 0;
    Want want = Want::neighbors;
    std::string peer;
    bool bounded = true;
    unsigned threads = 1;
    std::vector<double> seconds;  // each repeat; empty: failed or skipped
    Answer answer;                // of the last repeat
    double box_volume = 0, volume_error = 0;
    std::vector<votess::StageSeconds> stages;  // each repeat, of votess
    std::string note;                          // why there is no time
};

double median(std::vector<double> values);

// The fields of StageSeconds but the total, in their order.
struct Stage {
    const char* name;
    double votess::StageSeconds::*seconds;
};
inline constexpr Stage stages[] = {
    {"upload", &votess::StageSeconds::upload},     {"sort", &votess::StageSeconds::sort},
    {"knn", &votess::StageSeconds::knn},           {"clip", &votess::StageSeconds::clip},
    {"fallback", &votess::StageSeconds::fallback}, {"download", &votess::StageSeconds::download}};
double median_of(const Stage& stage, const std::vector<votess::StageSeconds>& runs);

// The device of that name among votess::devices(), for Stats::device and what Options::device accepts.
votess::DeviceInfo describe(const std::string& device, const std::string& name);

struct PeerVersion {
    std::string name, version;
};
void print_table(const std::vector<Measurement>& group);
// Written whole or not at all. Throws std::runtime_error.
void write_json(const std::string& file, const std::vector<PeerVersion>& peers,
                const std::vector<Measurement>& measurements);
void print_machine();

// For other JSON files.
std::string in_quotes(std::string_view text);
std::string machine_json();
// {"upload": [seconds of each run], ...}
std::string stages_json(const std::vector<votess::StageSeconds>& runs);
void write_whole(const std::string& file, const std::string& text);  // or not at all: throws std::runtime_error

}  // namespace bench
