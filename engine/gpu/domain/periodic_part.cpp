#include "gpu/domain/periodic_part.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "core/box.hpp"
#include "exact/integer/wide_int.hpp"

namespace votess::gpu {
namespace {

// This share of a vector exceeds the error of fractions. Places are right to 2^-52 of the box, which spans at most
// max_shifts of the vectors.
constexpr double fraction_slack = 0.01;
constexpr std::int64_t largest_shift = 63;  // so that differences of two of them fit into rows

// Numbers of units with 64 fractional bits, modulo 2^128. Coordinates and vectors are right to 2^-64, sums with 2^31
// vectors to 2^-30.
using Fixed = exact::Uint128;
using Fixed3 = std::array<Fixed, 3>;
using Units3 = std::array<std::uint64_t, 3>;

// Returns x 2^shift, rounded down.
Fixed fixed(double x, int shift, bool& lossy) {
    if (x == 0) return 0;
    int exponent = 0;
    const auto mantissa = static_cast<exact::Int128>(std::ldexp(std::frexp(x, &exponent), 53));
    const int n = exponent - 53 + shift + 64;
    if (n >= 128) return 0;
    if (n >= 0) return static_cast<Fixed>(mantissa) << n;
    const int right = std::min(-n, 127);
    lossy = lossy || (right >= 64 || ((mantissa >> right) << right) != mantissa);
    return static_cast<Fixed>(mantissa >> right);
}

void add(Fixed3& x, std::int64_t times, const Fixed3& vector) {
    if (times == 0) return;
    for (std::size_t k = 0; k < 3; ++k) x[k] += static_cast<Fixed>(exact::Int128{times}) * vector[k];
}

// Members that a task makes.
struct Block {
    std::vector<std::int32_t> members;
    std::vector<std::array<std::int8_t, 3>> shifts;
    std::vector<std::uint64_t> coordinates;
    std::vector<exact::Shift> places;  // of seeds: shifts from their places as given
    bool lossy = false;
    bool refused = false;  // a seed is too far away, or a shift too large
    bool wrapped = false;  // a seed was outside of the domain

    void add(std::size_t seed, const Fixed3& x, const std::array<std::int64_t, 3>& shift) {
        members.push_back(static_cast<std::int32_t>(seed));
        shifts.push_back({static_cast<std::int8_t>(shift[0]), static_cast<std::int8_t>(shift[1]),
                          static_cast<std::int8_t>(shift[2])});
        for (const Fixed c : x) {
            coordinates.push_back(static_cast<std::uint64_t>(c >> 64));
            lossy = lossy || static_cast<std::uint64_t>(c) != 0;
        }
    }
};

class Images {
public:
    Images(const Job& job, const ImageRange& range, PeriodicPart& out, ThreadPool& pool)
        : job_(job), domain_(*job.domain), range_(range), out_(out), pool_(pool), units_(Units::for_box(range.box)) {
        out.box = range.box;
        bool rounded = false;
        for (std::size_t k = 0; k < 3; ++k) {
            origin_[k] = units_.of(range.box.lower[k], rounded);
            extent_[k] = units_.of(range.box.upper[k], rounded) - origin_[k];
        }
        const int shift = units_.shift - std::ilogb(job.scale);
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k) {
                const exact::DoubleDouble& length = domain_.lattice.vector[j][k];
                vector_[j][k] = fixed(length.high, shift, vectors_lossy_) + fixed(length.low, shift, vectors_lossy_);
            }
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t i = 0; i < 3; ++i) add(basis_[j], range.basis->shift[j][i], vector_[i]);
    }

    // Adds the seeds at their places. Returns false when one is too far away.
    bool add_seeds();
    // Returns false when there are more than `most` members.
    bool add_images(std::uint32_t most);
    void set_bounds() const;

private:
    void add_seeds(std::size_t first, std::size_t end, Block& block);
    void add_images(std::size_t first, std::size_t end, Block& block) const;
    // Makes blocks of `count` items side by side, and appends them in order. Returns false when one is refused.
    bool make(std::size_t count, std::uint32_t most, const auto& make_block);

    [[nodiscard]] Fixed3 place(std::size_t seed, const exact::Shift& shift, bool& lossy) const {
        Fixed3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = fixed(job_.points[3 * seed + k], units_.shift, lossy);
        for (std::size_t j = 0; j < 3; ++j) add(x, shift[j], vector_[j]);
        lossy = lossy || (vectors_lossy_ && shift != exact::Shift{});
        return x;
    }
    // Returns the offset from the domain's origin of a place less than 2^62 units outside of the box.
    [[nodiscard]] exact::Point offset(const Fixed3& x) const {
        exact::Point at;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto units = static_cast<std::int64_t>(static_cast<std::uint64_t>(x[k] >> 64) - origin_[k]);
            at[k] = (range_.box.lower[k] + std::ldexp(static_cast<double>(units), -units_.shift)) * job_.scale -
                    domain_.origin[k];
        }
        return at;
    }
    // Compares units. Places 2^64 units apart, at least four sides of the box, look alike; the offset tells them apart.
    [[nodiscard]] bool is_inside(const Fixed3& x, const exact::Point& offset) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (static_cast<std::uint64_t>(x[k] >> 64) - origin_[k] > extent_[k]) return false;
            const double begin = range_.box.lower[k] * job_.scale - domain_.origin[k];
            const double side = (range_.box.upper[k] - range_.box.lower[k]) * job_.scale;
            if (offset[k] < begin - side || offset[k] > begin + 2 * side) return false;
        }
        return true;
    }

    const Job& job_;
    const Domain& domain_;
    const ImageRange& range_;
    PeriodicPart& out_;
    ThreadPool& pool_;
    Units units_;
    Units3 origin_{}, extent_{};  // of the box, in units modulo 2^64
    std::array<Fixed3, 3> vector_{}, basis_{};
    bool vectors_lossy_ = false;
    std::vector<exact::Shift> wraps_;   // by seed
    std::vector<exact::Shift> places_;  // by member: shift from the seed's place as given
    bool any_wrapped_ = false;
};

bool Images::make(std::size_t count, std::uint32_t most, const auto& make_block) {
    constexpr std::size_t items = 1u << 13;  // of a block
    std::vector<Block> blocks((count + items - 1) / items);
    std::atomic<std::size_t> members = out_.part.members.size();
    pool_.run(blocks.size(), [&](std::size_t b, unsigned) {
        if (members > most) return;
        make_block(b * items, std::min((b + 1) * items, count), blocks[b]);
        members += blocks[b].members.size();
    });
    if (members > most) return false;
    std::vector<std::size_t> begins;
    std::size_t begin = out_.part.members.size();
    for (const Block& block : blocks) {
        if (block.refused) return false;
        begins.push_back(begin);
        begin += block.members.size();
        out_.lossy = out_.lossy || block.lossy;
        any_wrapped_ = any_wrapped_ || block.wrapped;
        places_.insert(places_.end(), block.places.begin(), block.places.end());
    }
    out_.part.members.resize(begin);
    out_.shifts.resize(begin);
    out_.coordinates.resize(3 * begin);
    pool_.run(blocks.size(), [&](std::size_t b, unsigned) {
        const auto at = static_cast<std::ptrdiff_t>(begins[b]);
        std::ranges::copy(blocks[b].members, out_.part.members.begin() + at);
        std::ranges::copy(blocks[b].shifts, out_.shifts.begin() + at);
        std::ranges::copy(blocks[b].coordinates, out_.coordinates.begin() + 3 * at);
    });
    return true;
}

void Images::add_seeds(std::size_t first, std::size_t end, Block& block) {
    for (std::size_t i = first; i < end; ++i) {
        if (!job_.outside.empty() && job_.outside[i] == CellStatus::outside) continue;
        const auto wrapped = wrap(domain_, point_of(job_.points, i, job_.scale));
        if (!wrapped) {  // the exact clipper reports it
            block.refused = true;
            return;
        }
        wraps_[i] = *wrapped;
        block.wrapped = block.wrapped || *wrapped != exact::Shift{};
        exact::Shift to = *wrapped;
        std::array<std::int64_t, 3> move{};
        if (domain_.skewed) {
            exact::Point at = domain_.translation(to);
            for (std::size_t k = 0; k < 3; ++k) at[k] += job_.points[3 * i + k] * job_.scale;
            const exact::Shift by = shift_into_reduced(domain_, at);
            for (std::size_t j = 0; j < 3; ++j) {
                if (std::abs(by[j]) > largest_shift) {
                    block.refused = true;
                    return;
                }
                to[j] += by[j];
                move[j] = by[j];
                out_.moves[i][j] = static_cast<std::int8_t>(by[j]);
            }
        }
        block.places.push_back(to);
        block.add(i, place(i, to, block.lossy), move);
    }
}

bool Images::add_seeds() {
    const std::size_t count = job_.points.count();
    wraps_.resize(count);
    if (domain_.skewed) out_.moves.resize(count);
    if (!make(count, std::numeric_limits<std::uint32_t>::max(),
              [&](auto first, auto end, Block& block) { add_seeds(first, end, block); }))
        return false;
    out_.part.own_count = static_cast<std::uint32_t>(out_.part.members.size());
    for (std::size_t i = 0; any_wrapped_ && i < count; ++i) {
        const exact::Point by = domain_.translation(wraps_[i]);
        out_.wraps.push_back({by[0] / job_.scale, by[1] / job_.scale, by[2] / job_.scale});
    }
    return out_.part.own_count > 0;
}

bool Images::add_images(std::uint32_t most) {
    return make(places_.size(), most, [&](auto first, auto end, Block& block) { add_images(first, end, block); });
}

void Images::add_images(std::size_t first, std::size_t end, Block& block) const {
    for (std::size_t own = first; own < end; ++own) {
        const auto seed = static_cast<std::size_t>(out_.part.members[own]);
        const Fixed3 x = place(seed, places_[own], block.lossy);
        const exact::Point at = offset(x);
        const auto f = range_.basis->fraction(at);
        std::array<int, 3> least{}, last{};
        for (std::size_t j = 0; j < 3; ++j) {
            if (!domain_.periodic[j]) continue;
            least[j] = static_cast<int>(std::ceil(range_.fractions.lower[j] - f[j] - fraction_slack));
            last[j] = static_cast<int>(std::floor(range_.fractions.upper[j] - f[j] + fraction_slack));
        }
        const auto try_image = [&](const std::array<int, 3>& steps) {
            if (steps == std::array<int, 3>{}) return;
            Fixed3 image = x;
            exact::Point image_at = at;
            std::array<std::int64_t, 3> shift{out_.shifts[own][0], out_.shifts[own][1], out_.shifts[own][2]};
            for (std::size_t j = 0; j < 3; ++j) {
                add(image, steps[j], basis_[j]);
                for (std::size_t k = 0; k < 3; ++k) {
                    image_at[k] += steps[j] * range_.basis->vector[j][k];
                    shift[k] += std::int64_t{steps[j]} * range_.basis->shift[j][k];
                }
            }
            if (!is_inside(image, image_at)) return;
            for (const std::int64_t s : shift) block.refused = block.refused || std::abs(s) > largest_shift;
            block.lossy = block.lossy || vectors_lossy_;
            block.add(seed, image, shift);
        };
        for (int a = least[0]; a <= last[0]; ++a)
            for (int b = least[1]; b <= last[1]; ++b)
                for (int c = least[2]; c <= last[2]; ++c) try_image({a, b, c});
    }
}

// Sets the bounds of the known images: all in the box, except those within rounding of its faces.
void Images::set_bounds() const {
    for (std::size_t k = 0; k < 3; ++k) {
        if (!range_.extended[k]) continue;
        out_.part.bounded |= 9u << k;
        out_.part.lower[k] = 2;
        out_.part.upper[k] = extent_[k] - 3;
        if (!domain_.triclinic) out_.part.period[k] = static_cast<std::uint64_t>(vector_[k][k] >> 64);
    }
}

}  // namespace

std::optional<PeriodicPart> periodic_part(const Job& job, const ImageRange& range, std::uint32_t max_seeds,
                                          ThreadPool& pool) {
    PeriodicPart result;
    Images images(job, range, result, pool);
    if (!images.add_seeds() || !images.add_images(max_seeds)) return std::nullopt;
    images.set_bounds();
    return result;
}

}  // namespace votess::gpu
