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

void Multigrid::Level::complete() {
    x.resize(size());
    b.resize(size());
    inverse.reserve(size());
    for (const float d : diagonal) inverse.push_back(d > 0 ? 1 / d : 0);
}

float Multigrid::Level::neighbors(std::size_t row) const {
    float sum = 0;
    for (std::size_t at = begin[row]; at < begin[row + 1]; ++at)
        sum += value[at] * x[static_cast<std::size_t>(column[at])];
    return sum;
}

void Multigrid::Level::sweep_forward() const {
    in_pieces(size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) x[i] = (b[i] + neighbors(i)) * inverse[i];
    });
}

void Multigrid::Level::sweep_backward() const {
    in_pieces(size(), [&](std::size_t first, std::size_t end) {
        for (std::size_t i = size() - first; i-- > size() - end;) x[i] = (b[i] + neighbors(i)) * inverse[i];
    });
}

Multigrid::Level Multigrid::coarser(const Level& fine) {
    Level coarse;
    const std::size_t rows = ceil_div(fine.size(), aggregate);
    coarse.diagonal.reserve(rows);
    std::vector<std::size_t> entry(rows, 0);  // one more than the place of an aggregate's entry
    in_pieces(rows, [&](std::size_t first_row, std::size_t end_row) {
        for (std::size_t row = first_row; row < end_row; ++row) {
            const std::size_t first = coarse.column.size(), end = std::min((row + 1) * aggregate, fine.size());
            double diagonal = 0;
            for (std::size_t at = fine.begin[row * aggregate]; at < fine.begin[end]; ++at) {
                const std::size_t to = static_cast<std::size_t>(fine.column[at]) / aggregate;
                if (to == row) continue;
                diagonal += fine.value[at];
                if (entry[to] <= first) {
                    coarse.column.push_back(static_cast<std::int32_t>(to));
                    coarse.value.push_back(0);
                    entry[to] = coarse.column.size();
                }
                coarse.value[entry[to] - 1] += fine.value[at];
            }
            coarse.diagonal.push_back(static_cast<float>(diagonal));
            coarse.begin.push_back(coarse.column.size());
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
    finest.begin.reserve(rows + 1);
    finest.diagonal.reserve(rows);
    finest.column.reserve(static_cast<std::size_t>(matrix.nonZeros()));
    finest.value.reserve(static_cast<std::size_t>(matrix.nonZeros()));
    in_pieces(rows, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) {
            finest.diagonal.push_back(0);
            for (std::int32_t at = matrix.outerIndexPtr()[i]; at < matrix.outerIndexPtr()[i + 1]; ++at) {
                const std::int32_t j = matrix.innerIndexPtr()[at];
                const auto value = static_cast<float>(matrix.valuePtr()[at] * scale);
                if (j == static_cast<std::int32_t>(i)) {
                    finest.diagonal.back() = value;
                } else {
                    finest.column.push_back(j);
                    finest.value.push_back(-value);
                }
            }
            finest.begin.push_back(finest.column.size());
        }
    });
    finest.complete();
    levels_.push_back(std::move(finest));
    while (levels_.back().size() > coarsest) levels_.push_back(coarser(levels_.back()));
    return *this;
}

void Multigrid::cycle(std::size_t index) const {
    const Level& level = levels_[index];
    std::ranges::fill(level.x, 0.0F);
    if (index + 1 == levels_.size()) {
        for (int i = 0; i < coarsest_sweeps; ++i) level.sweep_forward(), level.sweep_backward();
        return;
    }
    const Level& coarse = levels_[index + 1];
    const int cycles = index == 0 ? 1 : 2;
    for (int c = 0; c < cycles; ++c) {
        level.sweep_forward();
        in_pieces(coarse.size(), [&](std::size_t first, std::size_t end) {
            for (std::size_t row = first; row < end; ++row) {
                float sum = 0;
                for (std::size_t i = row * aggregate; i < std::min((row + 1) * aggregate, level.size()); ++i)
                    sum += level.b[i] + level.neighbors(i) - level.diagonal[i] * level.x[i];
                coarse.b[row] = sum;
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
