#include "distributed/stream/plan.hpp"

#include <algorithm>
#include <cmath>

#include "votess/stream.hpp"

namespace votess::stream {
namespace {

constexpr double entries = 15.6;  // in a row, for uniform seeds
constexpr double min_block = 500;
// A block may take this share of the memory. The rest is for outlines, messages and uneven blocks. Threads take their
// part whatever the blocks are.
constexpr double share_of_block = 0.9, of_threads = 40e6, max_of_threads = 0.25;

// Returns the bytes of the wanted arrays of a cell, or of an entry, in memory.
double bytes_of(const Want& want, Per per) {
    double bytes = 0;
    for_row_arrays([&](const auto& array, std::size_t) {
        const bool of_rows = array.word == &Want::neighbors;
        if (array.per == per && array.word != nullptr && !of_rows && want.*array.word)
            bytes += static_cast<double>(array.components * sizeof(array.of(std::declval<StreamRows&>())[0]));
    });
    return bytes;
}
double measures(const Want& want) {
    return bytes_of(want, Per::cell);
}
double values(const Want& want) {
    return entries * bytes_of(want, Per::entry);
}

// Returns the seeds of a block and its halo, see Tile::width.
double with_halo(double seeds) {
    const double side = std::cbrt(std::max(seeds, 1.0)), halos = 5;
    return seeds * std::pow(1 + halos / side, 3);
}

// Returns the bytes of a block: while its seeds and halo, as given and in their places, are sorted, or while its cells
// are clipped. A block needs radii, or rows to find these.
double bytes_of_block(double seeds, const Kind& kind) {
    const Want& want = kind.want;
    const bool measured = want.volumes || want.centroids || want.surfaces || want.radii || want.areas;
    const bool rows = want.neighbors || !measured;
    const double of_seed =
        32 + 4 + (kind.weighted ? 24 : 0) + (kind.periodic ? 36 : 0) + (kind.verified ? 4 : 0) + 24 + 4 + 4 + 7;
    constexpr double to_sort = 40;  // lent to the rows
    const double of_cell = 24 + 4 + 1 + measures(want) + (measured && !want.radii ? 8 : 0) + (rows ? 8 + 8 : 0) +
                           (rows ? entries * (4 + 2.5 + (kind.periodic ? 6 : 0)) + 2 * values(want) : 0);
    const double cells = seeds * of_cell, sorting = with_halo(seeds) * to_sort;
    return with_halo(seeds) * of_seed + (rows ? cells + sorting : std::max(cells, sorting + seeds * (24 + 4)));
}

}  // namespace

std::size_t blocks_for(std::uint64_t memory, std::uint64_t seeds, const Kind& kind) {
    const double given = static_cast<double>(memory), all = static_cast<double>(seeds);
    const double room = share_of_block * given - std::min(of_threads, max_of_threads * given);
    double blocks = 1;
    while (bytes_of_block(all / blocks, kind) > room && all / blocks > min_block)
        blocks = std::max(blocks + 1, std::floor(blocks * 1.05));
    return static_cast<std::size_t>(blocks);
}

std::uint64_t bytes_on_disk(std::uint64_t seeds, std::size_t blocks, const Kind& kind) {
    const double all = static_cast<double>(seeds), count = static_cast<double>(blocks);
    const double of_id = count < 100 ? 1.3 : 2, of_tiles = 0.5;
    const double of_seed = of_id + (kind.singles ? 12 : 24) + (kind.weighted ? 8 : 0);
    const double of_row = kind.want.neighbors ? 1 + entries * (4 + (kind.periodic ? 3 : 0)) + values(kind.want) : 0;
    // Counts take a byte each, and statuses nearly nothing.
    Want measured = kind.want;
    measured.counts = false;
    const double of_cell = 0.1 + measures(measured) + (kind.want.counts ? 1 : 0);
    // A proof needs the rows of cells next to other blocks there, with all seeds that these name.
    const double at_border = std::min(1.0, 6 / std::cbrt(std::max(all / count, 1.0)));
    const double of_border = kind.verified && kind.want.neighbors && blocks > 1 ? 6 * of_seed + of_row : 0;
    return static_cast<std::uint64_t>(with_halo(all / count) * count * of_seed +
                                      all * (of_tiles + of_row + of_cell + at_border * of_border));
}

}  // namespace votess::stream
