// A result against another run, array by array.
#pragma once

#include <string>

#include "input/job.hpp"
#include "result/result.hpp"

namespace votess {

// Returns a text on arrays that no result has: rows that do not follow each other, or numbers of entries, vertices or
// corners that do not exist. "" if there are none.
[[nodiscard]] std::string malformed(const detail::Result& result);

// Runs the seeds again and returns a text on the first number that differs by more than the tolerance, which is
// relative to the number, the vector, or what suits the distance between seeds. "" if there is none. again: of the same
// seeds, domain and subset.
[[nodiscard]] std::string difference_from_second_run(const detail::Result& result, Settled again, double tolerance);

// Compares a result of some cells, or without small faces or rows, with a run of all cells and faces, whose rows and
// security radii are there. Returns a text as difference_from_second_run() does.
[[nodiscard]] std::string difference_from_whole(const detail::Result& part, const detail::Result& whole,
                                                double tolerance);

}  // namespace votess
