#include "cpu/sort.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace votess::cpu {
namespace {

using Index = std::int32_t;

struct Item {
    std::uint64_t key;
    Index index;
};

constexpr std::size_t crowded = 16;        // seeds in one block before it is binned again
constexpr int most_bits = 20;              // per axis: 3 * 20 bits fit the key
constexpr std::size_t task_seeds = 65536;  // seeds per parallel task

template <class Real>
struct Cloud {
    std::span<const Real> points;
    double scale;
    [[nodiscard]] std::array<double, 3> at(Index i) const {
        const Real* p = points.data() + 3 * static_cast<std::size_t>(i);
        return {p[0] * scale, p[1] * scale, p[2] * scale};
    }
};

struct Bounds {
    std::array<double, 3> lower, upper;
    Bounds() {
        lower.fill(std::numeric_limits<double>::infinity());
        upper.fill(-std::numeric_limits<double>::infinity());
    }
    void add(const std::array<double, 3>& p) {
        for (int k = 0; k < 3; ++k) {
            lower[k] = std::min(lower[k], p[k]);
            upper[k] = std::max(upper[k], p[k]);
        }
    }
    void add(const Bounds& b) {
        add(b.lower);
        add(b.upper);
    }
    [[nodiscard]] double longest() const {
        return std::max({upper[0] - lower[0], upper[1] - lower[1], upper[2] - lower[2]});
    }
};

// Position along the Hilbert curve (Skilling, Programming the Hilbert curve, AIP Conf. Proc. 707, 2004): the axes are
// turned into the transposed index in place, then its bits are interleaved.
std::uint64_t hilbert_index(std::array<std::uint32_t, 3> axes, int bits) {
    for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1) {
        const std::uint32_t p = q - 1;
        for (int i = 0; i < 3; ++i) {
            // Invert the low bits of axis 0 when the bit is set, else exchange them with axis i; without branches.
            const std::uint32_t set = (axes[i] & q) != 0 ? ~0u : 0u;
            const std::uint32_t exchange = (axes[0] ^ axes[i]) & p & ~set;
            axes[0] ^= (p & set) | exchange;
            axes[i] ^= exchange;
        }
    }
    axes[1] ^= axes[0];
    axes[2] ^= axes[1];
    std::uint32_t t = 0;
    for (std::uint32_t q = 1u << (bits - 1); q > 1; q >>= 1)
        if ((axes[2] & q) != 0) t ^= q - 1;
    for (auto& a : axes) a ^= t;
    auto spread = [](std::uint64_t v) {  // bit i to bit 3i
        v &= 0x1fffff;
        v = (v | v << 32) & 0x1f00000000ffffull;
        v = (v | v << 16) & 0x1f0000ff0000ffull;
        v = (v | v << 8) & 0x100f00f00f00f00full;
        v = (v | v << 4) & 0x10c30c30c30c30c3ull;
        v = (v | v << 2) & 0x1249249249249249ull;
        return v;
    };
    return spread(axes[0]) << 2 | spread(axes[1]) << 1 | spread(axes[2]);
}

int bits_for(std::size_t count) {
    // 8^bits blocks for about two seeds a block.
    const int b = (std::bit_width(count / 2) + 2) / 3;
    return std::clamp(b, 2, most_bits);
}

// Maps coordinates to grid blocks; equal coordinates to equal blocks, the ends of the longest axis to its two ends.
class Grid {
public:
    Grid(const Bounds& bounds, int bits)
        : lower_(bounds.lower), longest_(bounds.longest()), bits_(bits), top_((1u << bits) - 1) {}
    [[nodiscard]] std::uint64_t key(const std::array<double, 3>& p) const {
        std::array<std::uint32_t, 3> axes;
        for (int k = 0; k < 3; ++k) {
            // Divided, not multiplied by an inverse that could overflow for a cluster of subnormal extent.
            const double at = (p[k] - lower_[k]) / longest_ * (top_ + 1.0);
            axes[k] = at < top_ ? static_cast<std::uint32_t>(at) : top_;
        }
        return hilbert_index(axes, bits_);
    }

private:
    std::array<double, 3> lower_;
    double longest_;
    int bits_;
    std::uint32_t top_;
};

// Stable least-significant-digit radix sort by the low `bits` of the key.
void radix_sort(std::span<Item> items, std::vector<Item>& buffer, int bits) {
    if (items.size() < 256) {
        std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
        return;
    }
    const int passes = (bits + 10) / 11;
    const int digit = (bits + passes - 1) / passes;
    const std::uint64_t mask = (1ull << digit) - 1;
    buffer.resize(std::max(buffer.size(), items.size()));
    std::span<Item> from = items, to(buffer.data(), items.size());
    std::vector<std::size_t> offset(mask + 1);
    for (int pass = 0; pass < passes; ++pass) {
        const int shift = pass * digit;
        std::fill(offset.begin(), offset.end(), 0);
        for (const Item& i : from) ++offset[(i.key >> shift) & mask];
        std::size_t sum = 0;
        for (auto& o : offset) sum += std::exchange(o, sum);
        for (const Item& i : from) to[offset[(i.key >> shift) & mask]++] = i;
        std::swap(from, to);
    }
    if (from.data() != items.data()) std::copy(from.begin(), from.end(), items.begin());
}

template <class Real>
class Sorter {
public:
    Sorter(Cloud<Real> cloud, SortedSeeds& out) : cloud_(cloud), out_(out) {}

    // Resolves runs of equal keys in items sorted by key.
    void resolve(std::span<Item> items) {
        for (std::size_t begin = 0; begin < items.size();) {
            std::size_t end = begin + 1;
            while (end < items.size() && items[end].key == items[begin].key) ++end;
            if (end - begin > 1) resolve_run(items.subspan(begin, end - begin));
            begin = end;
        }
    }

private:
    void resolve_run(std::span<Item> run) {
        if (run.size() <= crowded) {
            for (std::size_t i = 1; i < run.size(); ++i)
                for (std::size_t j = 0; j < i; ++j)
                    if (cloud_.at(run[i].index) == cloud_.at(run[j].index)) {
                        mark_duplicate(run[i].index, run[j].index);
                        break;
                    }
            return;
        }
        Bounds bounds;
        for (const Item& i : run) bounds.add(cloud_.at(i.index));
        if (bounds.lower == bounds.upper) {
            for (std::size_t i = 1; i < run.size(); ++i) mark_duplicate(run[i].index, run[0].index);
            return;
        }
        const int bits = bits_for(run.size());
        const Grid grid(bounds, bits);
        for (Item& i : run) i.key = grid.key(cloud_.at(i.index));
        radix_sort(run, buffer_, 3 * bits);
        resolve(run);
    }

    // Sorting is stable, so `first` is the lowest index among equals.
    void mark_duplicate(Index index, Index first) {
        if (out_.duplicate_of.empty()) out_.duplicate_of.assign(cloud_.points.size() / 3, -1);
        out_.duplicate_of[index] = first;
        ++out_.duplicates;
    }

    Cloud<Real> cloud_;
    SortedSeeds& out_;
    std::vector<Item> buffer_;
};

template <class Real>
SortedSeeds sort_cloud(std::span<const Real> points, double scale, unsigned resolution, ThreadPool& pool) {
    SortedSeeds out;
    const Cloud<Real> cloud{points, scale};
    const std::size_t count = points.size() / 3;
    const std::size_t tasks = (count + task_seeds - 1) / task_seeds;
    auto range = [&](std::size_t task, std::size_t total) {
        return std::pair{task * task_seeds, std::min(total, (task + 1) * task_seeds)};
    };
    std::vector<Bounds> partial(tasks);
    pool.run(tasks, [&](std::size_t t, unsigned) {
        const auto [begin, end] = range(t, count);
        for (std::size_t i = begin; i < end; ++i) partial[t].add(cloud.at(static_cast<Index>(i)));
    });
    Bounds bounds;
    for (const Bounds& b : partial) bounds.add(b);

    std::vector<Item> items(count);
    const int bits = resolution == 0 ? bits_for(count) : std::clamp<int>(std::bit_width(resolution - 1), 1, most_bits);
    const bool single_point = count == 0 || bounds.lower == bounds.upper;
    pool.run(tasks, [&](std::size_t t, unsigned) {
        const Grid grid(bounds, bits);
        const auto [begin, end] = range(t, count);
        for (std::size_t i = begin; i < end; ++i)
            items[i] = {single_point ? 0 : grid.key(cloud.at(static_cast<Index>(i))), static_cast<Index>(i)};
    });
    {
        std::vector<Item> buffer;
        radix_sort(items, buffer, 3 * bits);
    }
    Sorter<Real>(cloud, out).resolve(items);
    if (out.duplicates > 0) std::erase_if(items, [&](const Item& i) { return out.duplicate_of[i.index] >= 0; });

    const std::size_t kept = items.size();
    // Padding lies infinitely far away, so that the last group is full.
    const std::size_t padded = (kept + group_size - 1) / group_size * group_size;
    for (auto* v : {&out.x, &out.y, &out.z}) v->assign(padded, std::numeric_limits<double>::infinity());
    out.input.resize(kept);
    pool.run((kept + task_seeds - 1) / task_seeds, [&](std::size_t t, unsigned) {
        const auto [begin, end] = range(t, kept);
        for (std::size_t i = begin; i < end; ++i) {
            const auto p = cloud.at(items[i].index);
            out.x[i] = p[0], out.y[i] = p[1], out.z[i] = p[2];
            out.input[i] = items[i].index;
        }
    });
    return out;
}

}  // namespace

SortedSeeds sort_seeds(std::span<const double> points, double scale, unsigned resolution, ThreadPool& pool) {
    return sort_cloud(points, scale, resolution, pool);
}

SortedSeeds sort_seeds(std::span<const float> points, double scale, unsigned resolution, ThreadPool& pool) {
    return sort_cloud(points, scale, resolution, pool);
}

}  // namespace votess::cpu
