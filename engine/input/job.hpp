// Input that has been checked: what every engine is given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "domain/domain.hpp"
#include "votess/votess.hpp"

namespace votess {

class Snapshot;

// The input as given; one of the two spans is in use.
struct Points {
    std::span<const double> f64;
    std::span<const float> f32;
    std::uint64_t first = 0;  // what messages call the first one, where these are some of an input

    [[nodiscard]] std::size_t coordinates() const { return f64.size() + f32.size(); }
    [[nodiscard]] std::size_t count() const { return coordinates() / 3; }
    [[nodiscard]] double operator[](std::size_t i) const { return f32.empty() ? f64[i] : f32[i]; }
};

// Validated input: the domain and the power of two that brings it to order one. Copies share what the domain points to.
struct Job {
    Points points;
    Options options;
    Box box;                // as given
    double box_volume = 0;  // of the domain, as given
    double scale = 1;
    std::shared_ptr<const Domain> domain;  // times scale
    std::vector<CellStatus> outside;       // N when some seeds lie outside of a wall: `outside` for them
    // N, when rows are to follow another order of the seeds than that of their indices: the place of each. The last
    // digits of what is measured depend on that order, and on no other.
    std::span<const std::int32_t> row_order;
    // The points are queries among so many seeds: their cells do not fit together.
    std::optional<std::int32_t> probes_of;
    // Arrays of an earlier run, whose memory ResultBuilder::begin() takes; may be null.
    detail::Result* arrays = nullptr;
    // Owner of the points. An engine that needs them no more may call release_pages(). May be null.
    Snapshot* snapshot = nullptr;
};

}  // namespace votess
