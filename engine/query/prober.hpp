// The cells that queries would have, each as if it alone were added to the seeds.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cpu/cell_builder.hpp"
#include "domain/probe.hpp"
#include "walk/star.hpp"

namespace votess::cpu {

// Receives the cells. k: the number of a probe in its run.
class ProbeSink {
public:
    virtual ~ProbeSink() = default;
    // False when the star does not know the cell well enough: it comes again, clipped.
    virtual bool take(std::size_t k, Star& star) = 0;
    virtual void take(std::size_t k, Cell& cell) = 0;
    // A sorted seed lies at the place of the probe, and is as heavy or heavier. Returns whether to call take_seed().
    virtual bool taken(std::size_t k, std::size_t seed) = 0;
    // Receives the cell of that seed.
    virtual void take_seed(std::size_t /*k*/, std::size_t /*seed*/, Cell& /*cell*/) {}
};

// One per thread. The seeds and all that belongs to them stay with the caller.
class Prober {
public:
    Prober(const SortedSeeds& seeds, const Hierarchy& hierarchy, const Kernels& kernels);

    void begin_job(const Domain& domain, Star::Keep keep);
    // probes: along a curve through space; near: a group of seeds near the first.
    void run(std::span<const Probe> probes, std::size_t near, ProbeSink& sink);

private:
    [[nodiscard]] std::size_t look_around(std::span<const Probe> probes);
    void clip(const Probe& probe, std::size_t k, ProbeSink& sink);

    const SortedSeeds& seeds_;
    CellBuilder builder_;
    std::unique_ptr<Star> star_;
    CellFaces faces_;
    Star::Keep keep_ = Star::Keep::nothing;
};

}  // namespace votess::cpu
