// clvotess-mpi: clvotess over the ranks of MPI, each with a share of the seeds.
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>
#include <votess/mpi.hpp>

#include "arguments/arguments.hpp"
#include "arguments/carried.hpp"
#include "domain.hpp"
#include "failure.hpp"
#include "mpi/options.hpp"
#include "mpi/ranks.hpp"
#include "mpi/read_share.hpp"
#include "mpi/write_ranks.hpp"
#include "progress.hpp"
#include "run/settle.hpp"
#include "summary.hpp"
#include "words.hpp"

namespace clvotess {
namespace {

void print(const std::string& text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
        throw runtime_failure("cannot write to stdout");
}

// Returns an empty result, which holds the domain of the run and the peak memory of the process.
votess::Tessellation without_seeds(votess::Options options) {
    options.want = {};
    return votess::tessellate(std::span<const double>(), options);
}

// Throws Failure for a duplicate. The library cannot: a rank does not know all seeds.
void refuse_duplicates(const Ranks& ranks, const InputShare& share, const votess::BlockCells& cells) {
    ranks.together([&] {
        for (std::size_t i = 0; i < cells.duplicate_of.size(); ++i)
            if (cells.duplicate_of[i] >= 0)
                throw bad_input("point " + std::to_string(share.first + i) + " is a duplicate of point " +
                                std::to_string(cells.duplicate_of[i]));
    });
}

// Adds the mass of each duplicate to the seed that keeps the cell, in the order of the rows. Another rank may hold that
// seed. Seeds are numbered by their rows.
void merge_masses_of_ranks(const Ranks& ranks, const InputShare& share, const votess::BlockCells& cells,
                           std::vector<double>& masses) {
    struct Mass {
        std::int64_t to;
        double value;
    };
    const std::vector<std::uint64_t> firsts = ranks.gather(share.first);
    std::vector<std::vector<char>> for_ranks(firsts.size());
    for (std::size_t i = 0; i < cells.duplicate_of.size(); ++i) {
        if (cells.duplicate_of[i] < 0) continue;
        const Mass mass{cells.duplicate_of[i], masses[i]};
        const auto owner = std::ranges::upper_bound(firsts, static_cast<std::uint64_t>(mass.to)) - firsts.begin() - 1;
        std::vector<char>& bytes = for_ranks[static_cast<std::size_t>(owner)];
        const auto* const begin = reinterpret_cast<const char*>(&mass);
        bytes.insert(bytes.end(), begin, begin + sizeof mass);
    }
    const std::vector<char> bytes = ranks.exchange(for_ranks);
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(Mass)) {
        Mass mass{};
        std::memcpy(&mass, bytes.data() + at, sizeof mass);
        masses[static_cast<std::uint64_t>(mass.to) - share.first] += mass.value;
    }
}

// Returns the statistics of all ranks as those of one run.
votess::Stats common_stats(const Ranks& ranks, const votess::mpi::Result& result, const votess::Tessellation& domain) {
    votess::Stats stats = domain.stats();
    std::uint64_t faces = 0, duplicates = 0, empty = 0;
    for (const std::uint32_t count : result.cells.face_counts) faces += count;
    for (const votess::CellStatus status : result.cells.status) {
        duplicates += status == votess::CellStatus::duplicate ? 1 : 0;
        empty += status == votess::CellStatus::certified ? 0 : 1;
    }
    stats.points = result.counts.seeds;
    stats.faces = ranks.sum(faces);
    stats.duplicates = ranks.sum(duplicates);
    stats.empty_cells = ranks.sum(empty);
    const std::uint64_t cells = stats.points - stats.empty_cells;
    stats.mean_faces = cells > 0 ? static_cast<double>(stats.faces) / static_cast<double>(cells) : 0;
    stats.exact_cells = result.counts.exact_cells;
    stats.volume_sum = result.counts.volume_sum;
    stats.box_volume = result.counts.box_volume;
    return stats;
}

int run(const Ranks& ranks, const Arguments& arguments) {
    const auto run_began = Clock::now();
    Summary summary;
    InputShare share = read_share(ranks, arguments);
    summary.seconds_read = seconds_since(run_began);

    Settled settled;
    ranks.together([&] { settled = settle(arguments, std::move(share.input)); });
    const Input& input = share.input = std::move(settled.input);
    votess::Options& options = settled.options;
    const DomainFrom& domain_from = settled.domain_from;
    std::vector<InputColumn>& carried = settled.carried;
    options.device = "cpu";
    if (!arguments.threads_given) options.threads = 1;
    options.want.neighbors = options.want.counts = true;
    const bool refuses_duplicates = options.duplicates == votess::Duplicates::error;
    options.duplicates = votess::Duplicates::merge;
    if (arguments.hull) options.walls = votess::mpi::hull_walls(MPI_COMM_WORLD, input.points, options);
    summary.input_note = input.note;
    summary.set_dimensions(options.planar, arguments.read.dimensions);

    const auto clip_began = Clock::now();
    votess::mpi::Result result = votess::mpi::tessellate(MPI_COMM_WORLD, input.points, {}, options);
    const double seconds_clip = seconds_since(clip_began);
    if (refuses_duplicates) refuse_duplicates(ranks, share, result.cells);

    std::vector<double> masses = masses_of(arguments, input);
    if (arguments.has_density) merge_masses_of_ranks(ranks, share, result.cells, masses);
    votess::Tessellation domain;
    ranks.together([&] {
        domain = without_seeds(result.options);
        fill_density(arguments, masses, result.cells.volumes, carried);
    });
    summary.set_domain(domain, domain_from);
    summary.has_volumes = arguments.wanted.volumes;
    summary.stats = common_stats(ranks, result, domain);
    summary.stats.seconds = {};
    summary.stats.seconds.clip = seconds_clip;
    const votess::mpi::Counts& counts = result.counts;
    summary.ranks = RanksSummary{ranks.size(), counts.rounds, counts.given, counts.needed};

    if (arguments.verify) summary.verified = votess::mpi::verify(MPI_COMM_WORLD, result, input.points);
    const std::string failure = summary.failure();

    const auto write_began = Clock::now();
    if (failure.empty())
        write_ranks(ranks, arguments.outputs, share, result.cells,
                    {input, domain, arguments.wanted, arguments.format, options.radii, domain_from, carried,
                     arguments.coloring});
    summary.seconds_write = seconds_since(write_began);
    summary.stats.peak_memory_bytes = ranks.maximum(without_seeds(result.options).stats().peak_memory_bytes);
    summary.seconds_total = seconds_since(run_began);
    ranks.first_alone([&] {
        if (arguments.json)
            print(json_summary(summary));
        else if (!arguments.quiet)
            print(plain_summary(summary));
    });
    if (!failure.empty()) throw CommonFailure(exit_code::verification_failed, failure);
    return exit_code::done;
}

int main_together(const Ranks& ranks, int count, const char* const* values) {
    Arguments arguments;
    ranks.together([&] {
        if (count > 1 && std::strcmp(values[1], "--voro++") == 0)
            throw bad_input("--voro++ writes the files of voro++, in text: run clvotess");
        arguments = read_arguments(count, values);
        if (arguments.answer.empty() && !arguments.list_devices) refuse_for_ranks(arguments);
        arguments.read.carries_words = false;  // ranks exchange numbers
    });
    if (!arguments.answer.empty() || arguments.list_devices) {
        ranks.first_alone([&] { print(answer_of_ranks(count, values)); });
        return exit_code::done;
    }
    return run(ranks, arguments);
}

void complain(const std::string& message) {
    std::fprintf(stderr, "clvotess-mpi: %s\n", one_line(message).c_str());
}

[[noreturn]] void abort_all(int code) {
    std::fflush(nullptr);
    MPI_Abort(MPI_COMM_WORLD, code);
    std::abort();
}

// Ends all ranks after a failure of one, because the others would wait for it.
[[noreturn]] void fail_alone(int rank, const std::string& message) {
    complain("rank " + std::to_string(rank) + ": " + message);
    abort_all(exit_code::runtime_failure);
}

int main_inside(int count, const char* const* values) {
    const Ranks ranks;
    const auto fail = [&](int code, const std::string& message) {
        if (ranks.rank() == 0) complain(message);
        // MPI_Finalize makes HDF5 close its files, which may crash after a failed close.
        if (code == exit_code::runtime_failure) {
            MPI_Barrier(MPI_COMM_WORLD);  // until all have removed their files, and rank 0 has printed the error
            abort_all(code);
        }
        return code;
    };
    try {
        return main_together(ranks, count, values);
    } catch (const CommonFailure& failure) {
        return fail(failure.code(), failure.what());
    } catch (const votess::Error& error) {  // which votess_mpi throws on all ranks
        return fail(exit_code_of(error.code()), in_words_of_options(error.what()));
    } catch (const std::bad_alloc&) {
        fail_alone(ranks.rank(), "out of memory: take more ranks, or fewer on a machine");
    } catch (const std::exception& error) {
        fail_alone(ranks.rank(), error.what());
    }
}

}  // namespace
}  // namespace clvotess

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    const int code = clvotess::main_inside(argc, argv);
    MPI_Finalize();
    return code;
}
