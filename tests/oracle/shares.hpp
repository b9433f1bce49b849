// Natural-neighbor coordinates in rational arithmetic: polytopes clipped by half spaces, without any code of the
// engine.
#pragma once

#include <gmpxx.h>

#include <array>
#include <map>
#include <span>
#include <vector>
#include <votess/votess.hpp>

namespace test {

struct Shares {
    bool meets_itself = false;  // the cell of the query has a face with an image of the query
    bool at_wall = false;
    mpq_class volume;  // of the cell of the query
    struct Share {
        mpq_class volume;                   // that the seed had before
        std::array<mpq_class, 3> gradient;  // of that volume, as the query moves
        double area = 0;                    // of the faces with the seed and its images, each over the distance
    };
    std::map<std::int32_t, Share> of;  // by seed, where one of them is positive
};

// The query is inside the domain and on no seed. weights: of the seeds, or none.
Shares exact_shares(std::span<const double> points, std::span<const double> weights, const votess::Options& options,
                    const std::array<double, 3>& query, double weight);

}  // namespace test
