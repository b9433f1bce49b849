#include "distributed/stream/plan.hpp"

#include <algorithm>
#include <cmath>

namespace votess::stream {
namespace {

constexpr double entries = 15.6;  // in a row, for uniform seeds
constexpr double min_block = 500;
// A block may take this share of the memory. The rest is for outlines, messages and uneven blocks. Threads take their
// part whatever the blocks are.
constexpr double share_of_block = 0.9, of_threads = 40e6, max_of_threads = 0.25;

// Returns the bytes of the wanted arrays for one cell. The entries of its row count `times`.
double wanted_bytes(const Want& want, double times) {
    return 8.0 * want.volumes + 24.0 * want.centroids + 12.0 * want.counts + 8.0 * want.surfaces + 8.0 * want.radii +
           times * entries * (8.0 * want.areas + 24.0 * want.normals);
}

// Returns the seeds of a block and its halo, see Tile::width.
double with_halo(double seeds) {
    const double side = std::cbrt(std::max(seeds, 1.0)), halos = 5;
    return seeds * std::pow(1 + halos / side, 3);
}

// Returns the bytes while a block is clipped: its seeds and halo, as given and sorted, and the cells, whose rows exist
// twice while they are ordered.
double bytes_of_block(double seeds, const Kind& kind) {
    const double of_seed = 32 + (kind.weighted ? 24 : 0) + 24 + 4 + 36 + 8 + (kind.periodic ? 36 : 0);
    const double of_cell =
        24 + 4 + 8 + 4 + 8 + 9 + entries * (4 + 4 + (kind.periodic ? 6 : 0)) + wanted_bytes(kind.want, 2);
    return with_halo(seeds) * of_seed + seeds * of_cell;
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
    const double of_seed = 32 + (kind.weighted ? 8 : 0);
    const double of_row = 4 + 1 + (kind.want.neighbors ? entries * (4 + (kind.periodic ? 3 : 0)) : 0);
    return static_cast<std::uint64_t>((with_halo(all / count) * count) * of_seed + all * 5 +
                                      all * (of_row + wanted_bytes(kind.want, 1)));
}

}  // namespace votess::stream
