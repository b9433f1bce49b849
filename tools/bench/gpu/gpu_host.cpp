// votess_bench_host: the host's work on the cells of a device, in nanoseconds of its threads' time for a cell. The
// cells are made up, so no device is needed; the code that processes them is that of the GPU engine.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <random>

#include "domain/domain.hpp"
#include "gpu/cells/host_cells.hpp"
#include "gpu/cells/pending_cells.hpp"

namespace {

using namespace votess;

// Seconds since the start of the program.
struct Moment {
    double wall, threads;
};

Moment now() {
    timespec spent{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
    return {std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(),
            static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec)};
}

// The output of a device; 15.5 neighbors a cell.
struct MadeUp {
    std::size_t count;
    std::vector<std::uint32_t> order, sorted_info, info, lengths;
    std::vector<std::int32_t> ids, left;
    std::vector<double> geometry, points;

    MadeUp(std::size_t n, double share_left) : count(n), order(n), sorted_info(n), info(n), lengths(n) {
        std::mt19937_64 random(1);
        std::uniform_int_distribution<std::uint32_t> faces(10, 21);
        std::uniform_real_distribution<double> uniform;
        for (std::size_t i = 0; i < n; ++i) {
            const bool is_left = uniform(random) < share_left;
            order[i] = static_cast<std::uint32_t>(i);
            lengths[i] = is_left ? 0 : faces(random);
            info[i] = is_left ? STATUS_NEEDS_EXACT
                              : (lengths[i] << INFO_FACES_SHIFT) | (27u << INFO_VERTICES_SHIFT) |
                                    (55u << INFO_EXPONENT_SHIFT);
            if (is_left) left.push_back(static_cast<std::int32_t>(i));
            for (std::uint32_t k = 0; k < lengths[i]; ++k)
                ids.push_back(static_cast<std::int32_t>(ids.size() * 2654435761u % n));
            for (int k = 0; k < 4; ++k) geometry.push_back(uniform(random));
            for (int k = 0; k < 3; ++k) points.push_back(uniform(random));
        }
        std::ranges::shuffle(order, random);
        for (std::size_t s = 0; s < n; ++s) sorted_info[s] = info[order[s]];
    }
};

constexpr std::size_t chunk_cells = std::size_t{1} << 20, slice_cells = std::size_t{1} << 18;

void run(const MadeUp& cells, unsigned threads) {
    ThreadPool pool(threads);
    ResultBuilder result;
    Job job;
    job.domain = std::make_shared<const Domain>();
    job.points.f64 = cells.points;
    job.want = {.neighbors = true, .volumes = true, .centroids = true};
    const std::vector<std::int32_t> row_of_left(16, 0);
    const std::span<const std::uint32_t> lengths = cells.lengths;

    const Moment start = now();
    result.begin(job, pool);
    const Moment begun = now();
    gpu::PendingCells left;
    for (std::size_t first = 0; first < cells.count; first += chunk_cells) {
        const std::size_t count = std::min(chunk_cells, cells.count - first);
        left.add_left(std::span(cells.sorted_info).subspan(first, count), std::span(cells.order).subspan(first, count),
                      {}, pool);
    }
    const Moment collected = now();
    const double row = static_cast<double>(cells.ids.size()) / static_cast<double>(cells.count);
    for (std::size_t done = 0; done < cells.count;) {
        done = std::min(done + chunk_cells, cells.count);
        result.touch(static_cast<double>(done) / static_cast<double>(cells.count), row, pool);
    }
    const Moment touched = now();
    // The CPU's own clipper would do this.
    for (const std::int32_t i : cells.left) {
        result.add_rows(std::span(&i, 1), std::array{16u}, row_of_left);
        result.arrays().volumes[static_cast<std::size_t>(i)] = 1;
    }
    const Moment clipped = now();
    const gpu::HostCells host({&job, &result, &pool, {}, {}, 61, cells.info});
    for (std::size_t first = 0; first < cells.count; first += slice_cells) {
        const std::size_t count = std::min(slice_cells, cells.count - first);
        host.finish(first, count, {std::as_bytes(std::span(cells.geometry).subspan(4 * first, 4 * count)), true});
    }
    const Moment measured = now();
    result.settle(lengths, pool);
    const Moment settled = now();
    for (std::size_t first = 0, entry = 0; first < cells.count; first += slice_cells) {
        const std::size_t count = std::min(slice_cells, cells.count - first);
        std::size_t entries = 0;
        for (const std::uint32_t length : lengths.subspan(first, count)) entries += length;
        host.place({first, lengths.subspan(first, count), std::span(cells.ids).subspan(entry, entries), {}, {}});
        entry += entries;
    }
    const Moment placed = now();
    detail::Result finished;
    result.finish(finished, pool);
    const Moment end = now();
    const auto each = [&](double seconds) { return 1e9 * seconds / static_cast<double>(cells.count); };
    const auto part = [&](const Moment& from, const Moment& to) { return each(to.threads - from.threads); };
    const double all = part(start, end) - part(collected, clipped);
    const double wall = (end.wall - start.wall) - (clipped.wall - collected.wall);
    std::printf("%9zu %7u %7.1f %7.1f %6.1f %8.1f %7.1f %6.1f %7.1f %7.1f %11.1f\n", cells.count, threads,
                part(start, begun), part(begun, collected), part(collected, touched), part(clipped, measured),
                part(measured, settled), part(settled, placed), part(placed, end), all,
                1e-6 * static_cast<double>(cells.count) / wall);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app(
        "What the host does with the cells that a device has made, in nanoseconds of its threads' time a cell");
    std::vector<double> sizes{1e6, 1e7};
    std::vector<unsigned> threads{1, 2};
    double share_left = 0.003;
    int repeats = 3;
    app.add_option("--n", sizes, "numbers of cells")
        ->delimiter(',')
        ->check(CLI::Range(1.0, 2e8))
        ->capture_default_str();
    app.add_option("--threads", threads)->delimiter(',')->check(CLI::Range(1u, 1024u))->capture_default_str();
    app.add_option("--left", share_left, "share of the cells that are left to the CPU")
        ->check(CLI::Range(0.0, 1.0))
        ->capture_default_str();
    app.add_option("--repeats", repeats)->check(CLI::PositiveNumber)->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    std::printf(
        "ns of threads' time a cell, and million cells a second. Pages are touched while the device works: `all` is\n"
        "without that.\n"
        "    cells threads   begin collect  pages geometry lengths   rows  finish     all  Mcells/s\n");
    for (const double size : sizes) {
        const MadeUp cells(static_cast<std::size_t>(size), share_left);
        for (const unsigned count : threads)
            for (int repeat = 0; repeat < repeats; ++repeat) run(cells, count);
    }
    return 0;
}
