// Damped Newton steps to the weights of given volumes.
#pragma once

#include <string>
#include <vector>

#include "fit/laplacian.hpp"
#include "votess/fit.hpp"

namespace votess::fit {

struct Problem {
    std::vector<double> points;  // 3N, along a Hilbert curve
    std::vector<double> places;  // 3N, the points inside a periodic domain
    Vector targets;              // N volumes
    Edges edges{};               // of the domain
    Options options;             // its domain, device, threads and tuning
};

struct Weighted {
    Vector weights, volumes;
    Tessellation tessellation;  // with neighbors and areas
    double residual = 0;        // largest |volume - target| / target
};

// The steps. Each counts itself in `out`, and adds its seconds.
//
// Where volumes and targets differ by factors, the derivative of a small cell is small, so its step is too long, and
// halving is slow. So a step aims at a goal: the targets, bounded by a factor around the volumes. The factor grows with
// each full step. In tight clusters the smallest cells grow first.
class Newton {
public:
    Newton(Problem problem, const FitOptions& options, VolumeFit& out);

    // Steps until now() is within the tolerance. Starts from `weights`, or from 0 where they leave a cell empty.
    // Returns false when steps end before; why() is the remedy.
    [[nodiscard]] bool run(Vector weights);
    [[nodiscard]] const Weighted& now() const { return now_; }  // the best so far
    [[nodiscard]] const std::string& why() const { return why_; }

private:
    [[nodiscard]] Weighted tessellate(Vector weights);
    [[nodiscard]] Vector goal() const;
    [[nodiscard]] Vector direction(const Vector& goal);
    // Takes the longest of the halved steps that empties no cell and comes nearer. Returns its share, or 0.
    [[nodiscard]] double advance(const Vector& step, const Vector& goal);

    Problem problem_;
    const FitOptions& options_;
    VolumeFit& out_;
    Tessellator tessellator_;
    Matrix matrix_;
    Weighted now_;
    double factor_, filling_;  // of the goal
    double first_residual_ = 0;
    std::string why_;
};

}  // namespace votess::fit
