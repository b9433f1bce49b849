// votess_bench: votess and its peers on the same points in the same run, in turns. Reports medians over the repeats.
// --goals, --table, --memory, --moving and --gpu-table measure other things.
#include "bench.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <thread>

#include "goals.hpp"
#include "gpu/gpu_table.hpp"
#include "measure.hpp"
#include "moving.hpp"
#include "system/machine.hpp"
#include "system/memory.hpp"

namespace bench {

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

enum class Mode { comparison, quick, sweep, goals, table, memory, moving, gpu_table };

struct Settings {
    Mode mode = Mode::comparison;
    // Empty or 0: the default of the mode.
    std::vector<std::size_t> sizes;
    std::vector<std::string> inputs;
    std::vector<std::string> wants;
    int repeat_count = 0;
    std::vector<unsigned> threads{1, 0};
    std::vector<std::string> peers;
    std::vector<std::string> devices;
    std::vector<std::string> instructions;
    std::vector<std::string> kernels;
    std::vector<unsigned> local_sizes;
    std::vector<std::string> numbers;
    Repeats repeats;
    std::uint64_t rng_seed = 1;
    std::string json;
    bool strict = false;
    bool check = false;
    double check_limit = 1e5;
    bool only_uniform_full = false;  // the other inputs without --want full

    void complete() {
        const bool quick = mode == Mode::quick, sweep = mode == Mode::sweep, memory = mode == Mode::memory;
        const bool moving = mode == Mode::moving;
        if (sizes.empty()) {
            sizes = {10'000, 100'000};
            if (quick) {
                sizes = {20'000};
            } else if (sweep) {
                sizes = {1'000, 3'000, 10'000, 30'000, 100'000, 300'000, 1'000'000};
            } else if (memory) {
                sizes = {1'000'000};
            } else if (moving) {
                sizes = {100'000};
            }
        }
        if (inputs.empty()) {
            inputs = {"uniform"};
            if (!memory) {
                inputs.emplace_back("clustered");
            }
            if (sweep) {
                inputs.insert(inputs.end(), {"radii", "smooth"});
            } else if (moving) {
                inputs.insert(inputs.end(), {"periodic", "triclinic", "octahedron", "radii"});
            }
        }
        only_uniform_full = sweep && wants.empty();
        if (wants.empty()) {
            wants = {"neighbors"};
            if (quick || sweep || memory || moving) {
                wants.emplace_back("full");
            }
        }
        repeats.count = repeat_count > 0 ? repeat_count : quick ? 3 : 5;
        if (sweep && repeats.at_least == 0) {
            repeats.at_least = 0.3;  // small inputs take milliseconds
        }
    }
};

Peers all_peers() {
    Peers peers;
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
#ifdef BENCH_GEOGRAM
    peers.push_back(make_geogram());
#endif
    return peers;
}

// votess first, on the CPU, then with the instructions that are asked for, then on devices.
Peers chosen_peers(const Settings& settings) {
    Peers peers;
    for (auto& peer : all_peers()) {
        const auto& names = settings.peers;
        if (names.empty() || peer->name() == "votess" || std::count(names.begin(), names.end(), peer->name()) > 0) {
            peers.push_back(std::move(peer));
        }
        if (peers.size() == 1) {
            for (const std::string& instructions : settings.instructions) {
                peers.push_back(make_votess(instructions));
            }
            for (const std::string& device : settings.devices) {
                peers.push_back(make_votess_on(device));
            }
        }
    }
    return peers;
}

int run_comparison(const Settings& settings, const Peers& peers, const std::vector<PeerVersion>& versions) {
    std::vector<Measurement> measurements;
    Timekeeper timekeeper;
    int complaints = 0;
    for (const std::string& name : settings.inputs) {
        for (const std::size_t n : is_file(name) ? std::vector<std::size_t>{0} : settings.sizes) {
            const Input input = make_input(name, n, settings.rng_seed);
            for (const std::string& want_name : settings.wants) {
                const Want want = want_of(want_name);
                if (want == Want::full && name != "uniform" && settings.only_uniform_full) {
                    continue;
                }
                std::vector<Contestant> contestants;
                for (const auto& peer : peers) {
                    for (const unsigned threads :
                         peer->can(input, want) ? peer->threads(settings.threads) : std::vector<unsigned>{}) {
                        contestants.push_back({peer.get(), &input, want, threads});
                    }
                }
                const auto group = timekeeper.measure(contestants, settings.repeats);
                print_table(group);
                std::fflush(stdout);
                complaints += settings.check ? check(group) : 0;
                measurements.insert(measurements.end(), group.begin(), group.end());
                if (!settings.json.empty()) {  // an interrupted run leaves the results so far
                    write_json(settings.json, versions, {section_of(measurements)});
                }
            }
        }
    }
    print_ratios(measurements);
    return complaints > 0 ? 1 : 0;
}

int run_gpu_table(const Settings& s) {
    GpuTable table;
    if (s.devices.size() > 1) {
        throw std::invalid_argument("--gpu-table takes one device");
    }
    table.device = s.devices.empty() ? table.device : s.devices.front();
    table.sizes = s.sizes.empty() ? table.sizes : s.sizes;
    table.inputs = s.inputs.empty() ? table.inputs : s.inputs;
    table.wants = s.wants.empty() ? table.wants : s.wants;
    table.kernels = s.kernels.empty() ? table.kernels : s.kernels;
    table.local_sizes = s.local_sizes.empty() ? table.local_sizes : s.local_sizes;
    table.numbers = s.numbers.empty() ? table.numbers : s.numbers;
    table.threads = s.threads.back();
    table.repeats = s.repeat_count > 0 ? s.repeat_count : table.repeats;
    table.limit = s.repeats.limit;
    table.rng_seed = s.rng_seed;
    table.json = s.json;
    table.check_limit = s.check_limit;
    return run_gpu_table(table);
}

int run_goals(const Settings& s, const Peers& peers, const std::vector<PeerVersion>& versions) {
    Goals goals;
    if (!s.sizes.empty()) {
        goals.small = s.sizes.front();
        goals.large = s.sizes.back();
    }
    if (s.inputs.size() > 1 || (!s.inputs.empty() && !is_file(s.inputs.front()))) {
        throw std::invalid_argument("--goals has its own inputs, and takes one --file besides");
    }
    goals.file = s.inputs.empty() ? "" : s.inputs.front();
    goals.repeats = s.repeats;
    goals.repeats.count = s.repeat_count;
    goals.rng_seed = s.rng_seed;
    goals.json = s.json;
    goals.strict = s.strict;
    goals.table = s.mode == Mode::table;
    goals.check = s.check;
    return run_goals(goals, peers, versions);
}

int run(Settings s) {
    if (s.mode == Mode::gpu_table) {
        return run_gpu_table(s);
    }
    if (s.mode == Mode::goals) {
        s.instructions = Goals::instructions();
    }
    const Peers peers = chosen_peers(s);
    print_machine();
    std::vector<PeerVersion> versions;
    for (const auto& peer : peers) {
        versions.push_back({peer->name(), peer->version()});
        std::printf("%s %s\n", versions.back().name.c_str(), versions.back().version.c_str());
    }
    if (s.mode == Mode::goals || s.mode == Mode::table) {
        return run_goals(s, peers, versions);
    }
    s.complete();
    if (s.mode == Mode::memory) {
        return run_memory_table({s.inputs, s.wants, s.sizes, s.threads, s.rng_seed, s.json}, peers, versions);
    }
    if (s.mode == Mode::moving) {
        return run_moving_table({s.inputs, s.wants, s.sizes, s.repeats.count, s.rng_seed, s.json}, versions);
    }
    return run_comparison(s, peers, versions);
}

}  // namespace
}  // namespace bench

int main(int argc, char** argv) try {
    using bench::Mode;
    bench::Settings s;
    std::vector<double> sizes;
    std::vector<std::string> peer_names, files;
    for (const auto& peer : bench::all_peers()) {
        peer_names.push_back(peer->name());
    }
    CLI::App app{"Compares votess with Voro++, Qhull, CGAL and GEOGRAM on the same points; or measures it on a GPU."};
    app.option_defaults()->delimiter(',');
    app.add_option("--n,--sizes", sizes, "numbers of seeds, such as 100000 or 1e5")
        ->check(CLI::Range(1.0, 1073741824.0));
    app.add_option("--input", s.inputs, "inputs, or file:PATH")
        ->check(
            CLI::IsMember(bench::input_names()) |
            CLI::Validator([](std::string& name) { return bench::is_file(name) ? "" : "no file:PATH"; }, "file:PATH"));
    app.add_option("--file", files, "--input file:PATH; text, a point a line: x y z or id x y z")
        ->check(CLI::ExistingFile);
    app.add_option("--threads", s.threads,
                   "threads of votess on the CPU, 0 = all; beside a device the largest number; the peers use one");
    app.add_option(
           "--want", s.wants,
           "neighbors; full: volumes, centroids and face areas too; proof: the program's own check of neighbors")
        ->check(CLI::IsMember({"neighbors", "full", "proof"}));
    auto* peers =
        app.add_option("--peers", s.peers, "besides votess; default: all found")->check(CLI::IsMember(peer_names));
    auto* devices =
        app.add_option("-x,--device", s.devices, "votess on these Vulkan devices too: gpu, lavapipe or an index");
    auto* instructions =
        app.add_option("--instructions", s.instructions, "votess with these too: baseline, avx2, avx512")
            ->check(CLI::IsMember({"baseline", "avx2", "avx512"}));
    auto* kernels =
        app.add_option("--kernel", s.kernels, "--gpu-table: automatic, invocation, subgroup; default the two")
            ->check(CLI::IsMember({"automatic", "invocation", "subgroup"}));
    auto* local_sizes =
        app.add_option("--local-size", s.local_sizes, "--gpu-table: invocations of a work-group; default 32,128")
            ->check(CLI::IsMember({8, 16, 32, 64, 128, 256, 512, 1024}));
    auto* numbers =
        app.add_option(
               "--numbers", s.numbers,
               "--gpu-table: that measure cells: automatic, float64, float32 (sums of two); default the last two")
            ->check(CLI::IsMember({"automatic", "float64", "float32"}));
    app.option_defaults()->delimiter('\0');

    app.add_option("--repeats", s.repeat_count, "runs of each; default 5; of large inputs of --goals 3")
        ->check(CLI::Range(1, 1000));
    app.add_option("--at-least", s.repeats.at_least, "more runs until those of one took so many seconds together");
    app.add_option("--patience", s.repeats.patience, "no more runs once those of one took so many seconds together")
        ->capture_default_str();
    app.add_option("--limit", s.repeats.limit, "leave out what would need longer for one run, in seconds")
        ->capture_default_str();
    app.add_option("--rng-seed", s.rng_seed, "seed of the inputs");
    app.add_option("--json", s.json, "write every measurement and the machine to this file");
    auto* check = app.add_flag("--check", s.check, "exit 1 when the peers disagree where they must not");

    const auto mode = [&app, &s](const char* name, Mode value, const char* text) {
        return app.add_flag_callback(
            name, [&s, value] { s.mode = value; }, text);
    };
    std::vector<CLI::Option*> modes{
        mode("--quick", Mode::quick, "2e4 seeds, neighbors and full, 3 repeats: under a minute"),
        mode("--sweep", Mode::sweep,
             "1e3 to 1e6 seeds, neighbors, of uniform ones full too, for figure.py; some 25 minutes"),
        mode("--goals", Mode::goals,
             "the speeds that votess sets out to reach, a line each; --n A,B tries it out with other numbers of "
             "seeds; some 5 minutes"),
        mode("--table", Mode::table,
             "votess beside Voro++, and other inputs beside plain ones: ratios of times a cell, and what they should "
             "be; some 5 minutes"),
        mode("--memory", Mode::memory, "peak of resident memory a point, each program in a process of its own"),
        mode("--moving", Mode::moving,
             "time of a call that follows moving seeds over that of a fresh one, 1e5 seeds, several domains, one "
             "thread; "
             "some 10 minutes; exit 1 when an answer differs"),
        mode("--gpu-table", Mode::gpu_table,
             "votess alone on one device, default gpu: 1e4 to 1e7 seeds, uniform, clustered, lattices, and one of each "
             "kind of domain; without "
             "--json into gpu-DEVICE-DATE.json in the current folder; exit 1 when a result is wrong")};
    CLI::Option *goals = modes[2], *ratios = modes[3], *memory = modes[4], *moving = modes[5], *gpu_table = modes[6];
    for (CLI::Option* one : modes) {
        for (CLI::Option* other : modes) {
            one != other ? one->excludes(other) : nullptr;
        }
    }
    gpu_table->excludes(peers)->excludes(instructions)->excludes(check);
    kernels->needs(gpu_table);
    local_sizes->needs(gpu_table);
    numbers->needs(gpu_table);
    for (CLI::Option* one : {goals, ratios}) {
        one->excludes(devices)->excludes(instructions);
    }
    memory->excludes(devices)->excludes(check);
    moving->excludes(devices)->excludes(check)->excludes(peers)->excludes(instructions);
    app.add_flag("--strict", s.strict, "--goals: exit 1 unless all are met")->needs(goals);
    app.add_option("--check-limit", s.check_limit, "--gpu-table: compare with the CPU up to so many seeds; default 1e5")
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
    for (const std::string& file : files) {
        s.inputs.push_back("file:" + file);
    }
    return bench::run(std::move(s));
} catch (const std::exception& error) {
    std::fprintf(stderr, "votess_bench: %s\n", error.what());
    return 1;
}
