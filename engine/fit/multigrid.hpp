// A preconditioner for the matrices of Laplacians whose rows follow a Hilbert curve.
#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace votess::fit {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double, Eigen::RowMajor, std::int32_t>;

// W cycles over aggregates of consecutive rows, which are compact clumps of cells, with Gauss-Seidel sweeps. It is
// symmetric and positive definite up to constants, in float32. Conjugate gradients take 4 to 12 steps on 1e4 and 1e5
// random seeds.
class Multigrid {
public:
    // As Eigen's preconditioners.
    using MatrixType = Matrix;
    using StorageIndex = Matrix::StorageIndex;
    enum { ColsAtCompileTime = Eigen::Dynamic, MaxColsAtCompileTime = Eigen::Dynamic };
    template <class Any>
    Multigrid& analyzePattern(const Any& /*matrix*/) {
        return *this;
    }
    Multigrid& factorize(const Eigen::Ref<const Matrix>& matrix);
    Multigrid& compute(const Eigen::Ref<const Matrix>& matrix) { return factorize(matrix); }
    [[nodiscard]] Vector solve(const Vector& right) const;
    [[nodiscard]] static Eigen::ComputationInfo info() { return Eigen::Success; }

private:
    // (D - A) x = b, with positive entries in A off the diagonal.
    struct Level {
        std::vector<std::size_t> begin{0};  // rows of A
        std::vector<std::int32_t> column;
        std::vector<float> value;
        std::vector<float> diagonal, inverse;  // of D; inverse is 0 where D is
        mutable std::vector<float> x, b;       // of the solve under way

        [[nodiscard]] std::size_t size() const { return diagonal.size(); }
        void complete();
        [[nodiscard]] float neighbors(std::size_t row) const;  // (A x) of a row
        void sweep_forward() const;
        void sweep_backward() const;
    };
    [[nodiscard]] static Level coarser(const Level& fine);
    void cycle(std::size_t level) const;

    std::vector<Level> levels_;
};

}  // namespace votess::fit
