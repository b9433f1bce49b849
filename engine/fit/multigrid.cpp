#include "fit/multigrid.hpp"

#include <algorithm>

#include "core/arithmetic.hpp"
#include "core/progress.hpp"

namespace votess::fit {
namespace {

constexpr std::size_t aggregate = 8;   // rows
constexpr std::size_t coarsest = 256;  // rows at most
constexpr int coarsest_sweeps = 20;
// A correction that is constant in each aggregate is too small: its steps cost more energy than a smooth one.
constexpr float over_correction = 1.6F;

}  // namespace

void Multigrid::Triangle::reserve(std::size_t rows, std::size_t entries) {
    begin_.reserve(rows + 1);
    eights_.reserve(entries / 8);
}

std::size_t Multigrid::Triangle::add(std::size_t column, float value) {
    if (next_ % 8 == 0) eights_.emplace_back();
    eights_.back().column[next_ % 8] = static_cast<std::int32_t>(column);
    this->value(next_) = value;
    return next_++;
}

void Multigrid::Triangle::end_row() {
    begin_.push_back(eights_.size());
    next_ = 8 * eights_.size();
}

float Multigrid::Triangle::product(std::size_t first_row, std::size_t end_row, const std::vector<float>& with) const {
    using Four __attribute__((vector_size(16))) = float;
    Four sum{};
    for (std::size_t e = begin_[first_row]; e < begin_[end_row]; ++e) {
        const Eight& eight = eights_[e];
        const auto& value = eight.value;
        const auto x = [&](std::size_t k) { return with[static_cast<std::size_t>(eight.column[k])]; };
        sum += Four{value[0], value[1], value[2], value[3]} * Four{x(0), x(1), x(2), x(3)} +
               Four{value[4], value[5], value[6], value[7]} * Four{x(4), x(5), x(6), x(7)};
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void Multigrid::Level::complete() {
    x.resize(size());
    b.resize(size());
    change.resize(size());
    inverse.reserve(size());
    for (const float d : diagonal) inverse.push_back(d > 0 ? 1 / d : 0);
}

void Multigrid::Level::sweep_forward(bool from_zero) const {
    in_pieces(size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) {
            const float before = from_zero ? 0 : x[i], right = from_zero ? 0 : upper.product(i, i + 1, x);
            x[i] = (b[i] + right + lower.product(i, i + 1, x)) * inverse[i];
            change[i] = x[i] - before;
        }
    });
}

void Multigrid::Level::sweep_backward() const {
    in_pieces(size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = size() - first; i-- > size() - end;)
            x[i] = (b[i] + lower.product(i, i + 1, x) + upper.product(i, i + 1, x)) * inverse[i];
    });
}

Multigrid::Level Multigrid::coarser(const Level& fine) {
    Level coarse;
    const std::size_t rows = ceil_div(fine.size(), aggregate);
    coarse.diagonal.reserve(rows);
    std::vector<std::size_t> in_lower(rows, 0), in_upper(rows, 0);  // one more than the number of an aggregate's entry
    in_pieces(rows, [&](std::size_t first_row, std::size_t end_row) {
        for (std::size_t row = first_row; row < end_row; ++row) {
            const std::size_t end = std::min((row + 1) * aggregate, fine.size());
            double diagonal = 0;
            const auto add = [&](const Triangle& from, std::vector<std::size_t>& entry, Triangle& to) {
                const std::size_t first = to.entries();
                from.for_entries(row * aggregate, end, [&](std::size_t column, float value) {
                    const std::size_t other = column / aggregate;
                    if (other == row || value == 0) return;
                    diagonal += value;
                    if (entry[other] <= first) entry[other] = to.add(other, 0) + 1;
                    to.value(entry[other] - 1) += value;
                });
                to.end_row();
            };
            add(fine.lower, in_lower, coarse.lower);
            add(fine.upper, in_upper, coarse.upper);
            coarse.diagonal.push_back(static_cast<float>(diagonal));
        }
    });
    coarse.complete();
    return coarse;
}

Multigrid& Multigrid::factorize(const Eigen::Ref<const Matrix>& matrix) {
    levels_.clear();
    Level finest;
    const auto rows = static_cast<std::size_t>(matrix.rows());
    // Entries become of order one, as float32 could overflow. The largest is on the diagonal.
    const double size =
        matrix.nonZeros() > 0 ? Eigen::Map<const Vector>(matrix.valuePtr(), matrix.nonZeros()).maxCoeff() : 0;
    const double scale = size > 0 ? 1 / size : 0;
    finest.diagonal.reserve(rows);
    const auto entries = static_cast<std::size_t>(matrix.nonZeros());
    for (Triangle* triangle : {&finest.lower, &finest.upper}) triangle->reserve(rows, entries);
    in_pieces(rows, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) {
            finest.diagonal.push_back(0);
            for (std::int32_t at = matrix.outerIndexPtr()[i]; at < matrix.outerIndexPtr()[i + 1]; ++at) {
                const std::int32_t j = matrix.innerIndexPtr()[at];
                const auto value = static_cast<float>(matrix.valuePtr()[at] * scale);
                if (j == static_cast<std::int32_t>(i))
                    finest.diagonal.back() = value;
                else
                    (j < static_cast<std::int32_t>(i) ? finest.lower : finest.upper)
                        .add(static_cast<std::size_t>(j), -value);
            }
            finest.lower.end_row();
            finest.upper.end_row();
        }
    });
    finest.complete();
    levels_.push_back(std::move(finest));
    while (levels_.back().size() > coarsest) levels_.push_back(coarser(levels_.back()));
    return *this;
}

void Multigrid::cycle(std::size_t index) const {
    const Level& level = levels_[index];
    if (index + 1 == levels_.size()) {
        for (int i = 0; i < coarsest_sweeps; ++i) level.sweep_forward(i == 0), level.sweep_backward();
        return;
    }
    const Level& coarse = levels_[index + 1];
    const int cycles = index == 0 ? 1 : 2;
    for (int c = 0; c < cycles; ++c) {
        level.sweep_forward(c == 0);
        // The residual of a row was 0 when it was swept. Later rows have changed it since.
        in_pieces(coarse.size(), [&](std::size_t first, std::size_t end) {
            for (std::size_t row = first; row < end; ++row) {
                const std::size_t end_row = std::min((row + 1) * aggregate, level.size());
                coarse.b[row] = level.upper.product(row * aggregate, end_row, level.change);
            }
        });
        cycle(index + 1);
        for (std::size_t i = 0; i < level.size(); ++i) level.x[i] += over_correction * coarse.x[i / aggregate];
        level.sweep_backward();
    }
}

Vector Multigrid::solve(const Vector& right) const {
    const Level& finest = levels_.front();
    const double size = right.lpNorm<Eigen::Infinity>();
    if (!(size > 0)) return right;
    for (std::size_t i = 0; i < finest.size(); ++i)
        finest.b[i] = static_cast<float>(right[static_cast<Eigen::Index>(i)] / size);
    cycle(0);
    Vector x(right.size());
    for (std::size_t i = 0; i < finest.size(); ++i) x[static_cast<Eigen::Index>(i)] = finest.x[i] * size;
    return x;
}

}  // namespace votess::fit
