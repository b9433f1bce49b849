// Zones of a watershed: from each cell steps lead to the lowest neighbor, until a minimum is reached.
//
//     const votess::Zones zones = votess::watershed(t, densities);
//     zones.labels[i] ...                            // the zone of cell i
//     const votess::Zones voids = zones.merge(0.2);  // joins zones across low saddles
//
// Method: zones as in ZOBOV (Neyrinck: ZOBOV: a parameter-free void-finding algorithm, MNRAS 386, 2008). They are
// joined by persistence (Edelsbrunner, Letscher, Zomorodian: Topological persistence and simplification, Discrete
// Comput. Geom. 28, 2002). Equal values are ordered by seed: the lower seed counts as lower. So the answer depends on
// rows and values alone. If no two values are equal, it does not depend on the order of the seeds either.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace votess {

// N seeds, Z zones, P pairs of adjacent zones. If `maxima` is set, read "highest" for lowest and "falls" for rises.
struct VOTESS_API Zones {
    bool maxima = false;
    std::vector<std::int32_t> labels;  // N: the zone of each cell; -1 for seeds without a cell
    std::vector<std::int32_t> cores;   // Z seeds, ascending: the minimum of each zone
    // 2P: adjacent zones, the lower number first. Pairs ascend by saddle, so the first pair with a zone is its lowest
    // way out.
    std::vector<std::int32_t> pairs;
    // P: the value to which a path from one zone into the other rises at least, if it visits no third zone.
    std::vector<double> saddles;
    std::vector<std::int32_t> passes;  // 2P seeds: the neighbors across which that path steps, the higher one first
    // The merge tree. As a level rises, zones below it meet at saddles. The one with the higher minimum then ends.
    std::vector<std::int32_t> parents;  // Z: the zone across the saddle at which each ends; -1 if it never does
    std::vector<double> persistence;    // Z: that saddle less the minimum, at least 0; infinity if it never ends
    // N if the rows list walls, else empty: 1 for a cell with a wall, and for one that reaches infinity.
    std::vector<std::uint8_t> at_walls;

    [[nodiscard]] std::size_t size() const noexcept { return cores.size(); }  // Z
    // Returns the zones that remain when each zone of at most this persistence joins its parent. The threshold has the
    // unit of the values; 0 joins zones that only equal values divide. Zones keep their persistence. Throws
    // invalid_argument for NaN.
    [[nodiscard]] Zones merge(double threshold) const;
};

// Returns the zones of N values, one for each cell. Infinite values are allowed: infinity keeps a cell from being a
// minimum unless all of its neighbors have it too. Walls do not count as neighbors. Values of seeds without a cell are
// ignored. maxima: steps lead to the highest neighbor. Throws invalid_argument for NaN, another number of values, and
// cells without neighbors in Want, of a subset, of probes.
[[nodiscard]] VOTESS_API Zones watershed(const Tessellation& tessellation, std::span<const double> values,
                                         bool maxima = false);

}  // namespace votess
