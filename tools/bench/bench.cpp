// votess_bench: votess and its peers on the same points in the same run, taking turns; medians over the repeats. With
// --gpu-table votess on one device, on many inputs.
#include "bench.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <thread>

#include "gpu_table.hpp"

namespace bench {

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

Rows rows_from_pairs(std::size_t n, const std::vector<std::pair<std::int32_t, std::int32_t>>& pairs) {
    Rows rows;
    rows.indptr.assign(n + 1, 0);
    for (const auto& [i, j] : pairs) {
        ++rows.indptr[static_cast<std::size_t>(i) + 1];
        ++rows.indptr[static_cast<std::size_t>(j) + 1];
    }
    for (std::size_t i = 0; i < n; ++i) {
        rows.indptr[i + 1] += rows.indptr[i];
    }
    rows.indices.resize(2 * pairs.size());
    std::vector<std::int64_t> next(rows.indptr.begin(), rows.indptr.end() - 1);
    for (const auto& [i, j] : pairs) {
        rows.indices[static_cast<std::size_t>(next[static_cast<std::size_t>(i)]++)] = j;
        rows.indices[static_cast<std::size_t>(next[static_cast<std::size_t>(j)]++)] = i;
    }
    return rows;
}

namespace {

struct Settings {
    std::vector<std::size_t> sizes;
    std::vector<std::string> inputs;
    std::vector<unsigned> threads{1, 0};
    std::vector<std::string> wants;
    std::vector<std::string> peers;
    std::vector<std::string> devices;
    int repeats = 5;
    double limit = 120;
    std::uint64_t rng_seed = 1;
    std::string json;
    bool quick = false;
    bool check = false;
    bool gpu_table = false;
};

std::vector<std::unique_ptr<Peer>> all_peers() {
    std::vector<std::unique_ptr<Peer>> peers;
    peers.push_back(make_votess());
#ifdef BENCH_VOROPP
    peers.push_back(make_voropp());
#endif
#ifdef BENCH_QHULL
    peers.push_back(make_qhull());
#endif
#ifdef BENCH_CGAL
    peers.push_back(make_cgal());
#endif
    return peers;
}

using Peers = std::vector<std::unique_ptr<Peer>>;

// A peer that will need longer than the limit is left out, judged by its slowest pace (seconds per point) so far.
using Paces = std::map<std::string, double>;

std::vector<Measurement> measure(const Peers& peers, const Input& input, Want want, const Settings& settings,
                                 Paces& paces) {
    struct Entry {
        const Peer* peer;
        Measurement measurement;
        std::string key;
    };
    std::vector<Entry> entries;
    for (const auto& peer : peers) {
        if (!peer->can(want)) {
            continue;
        }
        for (const unsigned threads : peer->threads(settings.threads)) {
            Entry entry{peer.get(), {}, {}};
            Measurement& m = entry.measurement;
            m.input = input.name;
            m.n = input.size();
            m.want = want;
            m.peer = peer->name();
            m.bounded = peer->bounded();
            m.threads = threads;
            m.volume_error = peer->volume_error();
            m.box_volume = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                m.box_volume *= input.box.upper[axis] - input.box.lower[axis];
            }
            entry.key =
                peer->name() + '/' + std::to_string(threads) + '/' + input.name + '/' + std::string(name_of(want));
            entries.push_back(std::move(entry));
        }
    }
    for (int repeat = 0; repeat < settings.repeats; ++repeat) {
        for (std::size_t k = 0; k < entries.size(); ++k) {
            // Each repeat begins with another peer: what one leaves in caches and clocks falls on all alike.
            Entry& entry = entries[(k + static_cast<std::size_t>(repeat)) % entries.size()];
            Measurement& m = entry.measurement;
            const double expected = paces[entry.key] * static_cast<double>(input.size());
            if (!m.note.empty() || (expected > settings.limit && repeat > 0)) {
                continue;
            }
            if (expected > settings.limit) {
                m.note = "left out: over --limit";
                continue;
            }
            try {
                if (repeat == 0) {
                    entry.peer->prepare(input, want, m.threads);
                }
                m.answer = entry.peer->run(input, want, m.threads);
                m.seconds.push_back(m.answer.seconds);
                if (m.answer.stats) {
                    m.stages.push_back(m.answer.stats->seconds);
                }
                double& pace = paces[entry.key];
                pace = std::max(pace, m.answer.seconds / static_cast<double>(std::max<std::size_t>(1, input.size())));
            } catch (const std::exception& error) {
                m.seconds.clear();
                m.note = std::string("failed: ") + error.what();
            }
        }
    }
    std::vector<Measurement> measurements;
    for (Entry& entry : entries) {
        measurements.push_back(std::move(entry.measurement));
    }
    return measurements;
}

bool close(double a, double b, double relative) {
    return std::abs(a - b) <= relative * std::max(std::abs(a), std::abs(b));
}

// --check: what must agree whatever the speed. Returns the number of complaints.
int check(const std::vector<Measurement>& group) {
    int complaints = 0;
    const auto complain = [&](const Measurement& m, const std::string& what) {
        std::fprintf(stderr, "check: %s n=%zu %s: %s\n", m.input.c_str(), m.n, m.peer.c_str(), what.c_str());
        ++complaints;
    };
    const Measurement& votess = group.front();
    for (const Measurement& m : group) {
        const bool mine = m.peer.starts_with("votess");
        if (m.seconds.empty()) {
            if (mine) {
                complain(m, m.note);
            }
            continue;
        }
        if (mine && m.answer.links != votess.answer.links) {
            complain(m, "another number of neighbors with other threads or on another device");
        }
        if (m.bounded && m.want == Want::full && !close(m.answer.volume, m.box_volume, m.volume_error)) {
            complain(m, "the volumes do not fill the box");
        }
        if (m.input == "lattice" && mine) {
            const auto side = static_cast<std::uint64_t>(std::lround(std::cbrt(static_cast<double>(m.n))));
            if (m.answer.links != 6 * (m.n - side * side)) {
                complain(m, "a cubic lattice has 6 neighbors a cell, fewer at the walls");
            }
        }
        // Rounding costs Voro++ a face in millions; ties and the sphere's center cost every inexact peer more.
        if (m.input == "uniform" || m.input == "clustered") {
            const auto ours = static_cast<double>(votess.answer.links), theirs = static_cast<double>(m.answer.links);
            if (m.bounded ? !close(ours, theirs, 1e-4) : theirs < ours * (1 - 1e-4)) {
                complain(m,
                         std::to_string(m.answer.links) + " neighbors, votess " + std::to_string(votess.answer.links));
            }
        }
    }
    return complaints;
}

int run(const Settings& settings) {
    Peers peers;
    std::vector<PeerVersion> versions;
    for (auto& peer : all_peers()) {
        const auto& names = settings.peers;
        if (names.empty() || peer->name() == "votess" || std::count(names.begin(), names.end(), peer->name()) > 0) {
            versions.push_back({peer->name(), peer->version()});
            peers.push_back(std::move(peer));
        }
        if (peers.size() == 1) {  // votess is the first
            for (const std::string& device : settings.devices) {
                peers.push_back(make_votess_on(device));
                versions.push_back({peers.back()->name(), peers.back()->version()});
            }
        }
    }
    print_machine();
    for (const PeerVersion& peer : versions) {
        std::printf("%s %s\n", peer.name.c_str(), peer.version.c_str());
    }

    std::vector<Measurement> measurements;
    Paces paces;
    int complaints = 0;
    for (const std::string& name : settings.inputs) {
        for (const std::size_t n : settings.sizes) {
            const Input input = make_input(name, n, settings.rng_seed);
            for (const std::string& want : settings.wants) {
                const auto group =
                    measure(peers, input, want == "full" ? Want::full : Want::neighbors, settings, paces);
                print_table(group);
                std::fflush(stdout);
                complaints += settings.check ? check(group) : 0;
                measurements.insert(measurements.end(), group.begin(), group.end());
            }
        }
    }
    if (!settings.json.empty()) {
        write_json(settings.json, versions, measurements);
    }
    return complaints > 0 ? 1 : 0;
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv) try {
    bench::Settings s;
    bench::GpuTable table;
    std::vector<double> sizes;
    double check_limit = 1e5;
    std::vector<std::string> peer_names;
    for (const auto& peer : bench::all_peers()) {
        peer_names.push_back(peer->name());
    }
    CLI::App app{"Compares votess with Voro++, Qhull and CGAL on the same points; or measures it on a GPU."};
    app.add_option("--n,--sizes", sizes, "numbers of seeds, such as 100000 or 1e5")
        ->delimiter(',')
        ->check(CLI::Range(1.0, 1073741824.0));
    app.add_option("--input", s.inputs, "inputs")->delimiter(',')->check(CLI::IsMember(bench::input_names()));
    app.add_option("--threads", s.threads,
                   "threads of votess on the CPU, 0 = all; beside a device the largest number; the peers use one")
        ->delimiter(',');
    app.add_option("--want", s.wants, "what to compute")->delimiter(',')->check(CLI::IsMember({"neighbors", "full"}));
    app.add_option("--repeats", s.repeats, "runs of each")->check(CLI::Range(1, 1000));
    app.add_option("-x,--device", s.devices, "votess on these Vulkan devices too: gpu, lavapipe or an index")
        ->delimiter(',');
    auto* peers = app.add_option("--peers", s.peers, "besides votess; default: all found")
                      ->delimiter(',')
                      ->check(CLI::IsMember(peer_names));
    app.add_option("--limit", s.limit, "leave out what would need longer for one run, in seconds");
    app.add_option("--rng-seed", s.rng_seed, "seed of the inputs");
    app.add_option("--json", s.json, "write every measurement and the machine to this file");
    auto* quick = app.add_flag("--quick", s.quick, "50,000 seeds, uniform and clustered, 3 repeats: under a minute");
    auto* check = app.add_flag("--check", s.check, "exit 1 when the peers disagree where they must not");
    auto* gpu_table = app.add_flag("--gpu-table", s.gpu_table,
                                   "votess alone on one device, default gpu: 1e4 to 1e7 seeds, uniform, clustered and "
                                   "lattice; without --json into gpu-DEVICE-DATE.json in the current folder; exit 1 "
                                   "when a result is wrong")
                          ->excludes(peers, quick, check);
    app.add_option("--check-limit", check_limit, "--gpu-table: compare with the CPU up to so many seeds; default 1e5")
        ->needs(gpu_table);
    CLI11_PARSE(app, argc, argv);

    const unsigned all = std::max(1U, std::thread::hardware_concurrency());
    for (unsigned& threads : s.threads) {
        threads = threads == 0 ? all : threads;
    }
    std::sort(s.threads.begin(), s.threads.end());
    s.threads.erase(std::unique(s.threads.begin(), s.threads.end()), s.threads.end());
    for (const double n : sizes) {
        s.sizes.push_back(static_cast<std::size_t>(n));
    }

    if (s.gpu_table) {
        if (s.devices.size() > 1) {
            throw std::invalid_argument("--gpu-table takes one device");
        }
        if (!s.devices.empty()) {
            table.device = s.devices.front();
        }
        if (!s.sizes.empty()) {
            table.sizes = s.sizes;
        }
        if (!s.inputs.empty()) {
            table.inputs = s.inputs;
        }
        if (!s.wants.empty()) {
            table.wants = s.wants;
        }
        table.threads = s.threads.back();
        table.repeats = s.repeats;
        table.limit = s.limit;
        table.rng_seed = s.rng_seed;
        table.json = s.json;
        table.check_limit = check_limit;
        return bench::run_gpu_table(table);
    }
    if (s.quick) {
        s.sizes = {50'000};
        s.inputs = {"uniform", "clustered"};
        s.repeats = 3;
    }
    if (s.sizes.empty()) {
        s.sizes = {10'000, 100'000};
    }
    if (s.inputs.empty()) {
        s.inputs = {"uniform", "clustered"};
    }
    if (s.wants.empty()) {
        s.wants = {"neighbors"};
    }
    return bench::run(s);
} catch (const std::exception& error) {
    std::fprintf(stderr, "votess_bench: %s\n", error.what());
    return 1;
}
