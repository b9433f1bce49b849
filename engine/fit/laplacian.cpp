#include "fit/laplacian.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <cmath>
#include <limits>

#include "core/progress.hpp"

namespace votess::fit {
namespace {

constexpr Eigen::Index max_iterations = 1000;  // a dozen are usual; a rough step is halved

}  // namespace

void set_laplacian(const Tessellation& t, std::span<const double> areas, std::span<const double> places,
                   const Edges& edges, Matrix& matrix) {
    const std::size_t count = t.size(), most = t.indices().size() + count;
    if (most > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
        throw Error(ErrorCode::unsupported, "fit_volumes(): " + std::to_string(t.indices().size()) +
                                                " neighbors are too many for its matrix: give fewer points");
    const std::span<const std::int8_t> shifts = t.shifts();
    const auto squared_distance = [&](std::size_t i, std::size_t at) {
        const auto j = static_cast<std::size_t>(t.indices()[at]);
        double squared = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            double along = places[3 * j + k] - places[3 * i + k];
            if (!shifts.empty())
                for (std::size_t e = 0; e < 3; ++e) along += shifts[3 * at + e] * edges[e][k];
            squared += along * along;
        }
        return squared;
    };

    const auto size = static_cast<Eigen::Index>(count);
    matrix.resize(size, size);
    matrix.resizeNonZeros(static_cast<Eigen::Index>(most));
    std::int32_t* const begin = matrix.outerIndexPtr();
    std::int32_t* const column = matrix.innerIndexPtr();
    double* const value = matrix.valuePtr();
    std::int32_t used = 0;
    const auto add_row = [&](std::size_t i) {
        begin[i] = used;
        const auto own = static_cast<std::int32_t>(i);
        double sum = 0;
        const auto add = [&](std::int32_t j, double derivative) {
            if (used == begin[i] || column[used - 1] != j) {
                column[used] = j;
                value[used++] = 0;
            }
            value[used - 1] += derivative;  // also of another image of the same neighbor
        };
        std::int32_t diagonal = -1;
        const auto add_diagonal = [&] {
            diagonal = used;
            add(own, 0);
        };
        const auto end = static_cast<std::size_t>(t.indptr()[i + 1]);
        for (auto at = static_cast<std::size_t>(t.indptr()[i]); at < end; ++at) {
            const std::int32_t j = t.indices()[at];
            if (j == own || j < 0) continue;  // its own image, of the same weight; a wall
            if (j > own && diagonal < 0) add_diagonal();
            const double derivative = areas[at] / (2 * std::sqrt(squared_distance(i, at)));
            sum += derivative;
            add(j, -derivative);
        }
        if (diagonal < 0) add_diagonal();
        value[diagonal] = sum;
    };
    in_pieces(count, [&](std::size_t first, std::size_t end) {
        for (std::size_t i = first; i < end; ++i) add_row(i);
    });
    begin[count] = used;
    matrix.resizeNonZeros(used);
}

Vector solve(const Matrix& matrix, const Vector& right, double tolerance) {
    Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper, Multigrid> solver(matrix);
    solver.setTolerance(tolerance);
    solver.setMaxIterations(max_iterations);
    // Squares of tiny volumes would be 0. The unit is a power of two: no digit changes.
    const double largest = right.cwiseAbs().maxCoeff();
    const double unit = largest > 0 ? std::exp2(std::ilogb(largest)) : 1;
    Vector x = solver.solve(Vector(right / unit));
    x.array() -= x.mean();
    return unit * x;
}

}  // namespace votess::fit
