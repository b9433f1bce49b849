// Weights for given volumes: the power diagram in which each cell has the volume that the caller gives.
//
//     votess::VolumeFit fit = votess::fit_volumes(points, targets, options);
//     fit.weights[i] ... fit.tessellation.volumes()[i] equals targets[i] to 1e-9
//
// Method: Newton steps (Kitagawa, Mérigot, Thibert: Convergence of a Newton algorithm for semi-discrete optimal
// transport, J. Eur. Math. Soc. 21, 2019) for the cube roots of volumes, which are nearer to linear in the weights. The
// derivative of a volume by a neighbor's weight is -area / (2 distance). Far from the targets a step goes part of the
// way on a logarithmic scale, and the cells that it leaves empty are revived. In tight clusters a fit of fewer seeds
// comes first (Mérigot: A multiscale approach to optimal transport, Comput. Graph. Forum 30, 2011). In the plane
// volumes are areas. The weights are those of optimal transport from the domain to the seeds, unique up to a constant.
// With a density, as an image, volumes are masses. Far from the targets the density is raised evenly, and sinks from
// step to step, so that cells in the dark have mass too.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/density.hpp>
#include <votess/votess.hpp>

namespace votess {

struct FitOptions {
    // Largest |volume - target| / target of the answer.
    double tolerance = 1e-9;
    // Newton steps; each takes at least one tessellation.
    unsigned max_steps = 200;
    // Scale the targets so that they sum to the volume of the domain or of the mesh, or to its mass: they are shares.
    bool normalize = false;
    // The targets are masses under this density instead of volumes. Not in a mesh.
    std::optional<Density> density = std::nullopt;
};

// Seconds of wall clock. `tessellate` includes the tessellation that is returned.
struct FitSeconds {
    double tessellate = 0, assemble = 0, solve = 0, total = 0;
};

// The mean of the weights is that at the start, unless seeds outside are kept.
struct VolumeFit {
    std::vector<double> weights;  // N, length unit squared, input order
    Tessellation tessellation;    // with these weights and the arrays of Options::want
    unsigned steps = 0;           // Newton steps of all seeds
    unsigned tessellations = 0;   // in all steps, also of fewer seeds, and the one that is returned
    double residual = 0;          // largest |volume - target| / target; of masses with a density
    FitSeconds seconds;
};

// Thrown when the steps end before the tolerance is reached. Its code is not_converged.
class VOTESS_API FitError : public Error {
public:
    FitError(const std::string& message, std::vector<double> weights, double residual, unsigned steps);
    ~FitError() override;
    FitError(const FitError&) = default;
    FitError& operator=(const FitError&) = default;

    // N: the best weights so far, with no empty cell. A fit that starts from them goes on.
    [[nodiscard]] const std::vector<double>& weights() const noexcept { return weights_; }
    [[nodiscard]] double residual() const noexcept { return residual_; }
    [[nodiscard]] unsigned steps() const noexcept { return steps_; }

private:
    std::vector<double> weights_;
    double residual_;
    unsigned steps_;
};

// Returns weights for which the cell of point i has the volume targets[i], and the tessellation with them. Options give
// the domain, the arrays of the tessellation, device and threads. Options::weights or radii are the start. By default,
// and where they leave a cell empty, the start is 0. The steps use double precision.
// Points outside that are kept have cells of their volumes inside. Dropped points have none; their targets do not
// count, and their weights are 0. In a periodic domain each kept point must have a cell without weights.
// In a mesh the volumes are those in it. Each cell must have a part of it without weights.
// Throws invalid_argument for equal points, points outside by default, and targets that are not positive, not one for
// each point or do not sum to the volume of the domain, or to its mass (to 1e-9); FitError when the steps end; and the
// errors of tessellate().
[[nodiscard]] VOTESS_API VolumeFit fit_volumes(std::span<const double> points, std::span<const double> targets,
                                               const Options& options = {}, const FitOptions& fit = {});

}  // namespace votess
