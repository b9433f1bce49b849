// The options that are one flag, number, word or text, for code that treats them all alike.
#pragma once

#include <votess/votess.h>

#include <array>

#include "core/arithmetic.hpp"
#include "votess/votess.hpp"

namespace votess {

template <class Number>
struct UpTo {
    Number max;
};
constexpr struct {
} anything;

// Calls use(name, member of Options, member of votess_options, allowed) for each. allowed: numbers from 0 UpTo a
// greatest one, the words in the order of the enumerators, or anything. tools/options.py writes the calls.
template <class Use>
void each_option(const Use& use) {
    use("outside", &Options::outside, &votess_options::outside, std::array{"error", "drop", "keep"});
    use("min_face", &Options::min_face, &votess_options::min_face, UpTo<double>{infinity});
    use("min_area", &Options::min_area, &votess_options::min_area, UpTo<double>{infinity});
    use("duplicates", &Options::duplicates, &votess_options::duplicates, std::array{"merge", "error"});
    use("list_walls", &Options::list_walls, &votess_options::list_walls, anything);
    use("device", &Options::device, &votess_options::device, anything);
    use("precision", &Options::precision, &votess_options::precision, std::array{"single", "double"});
    use("threads", &Options::threads, &votess_options::threads, UpTo<unsigned>{1024});
    use("grid_resolution", &Options::grid_resolution, &votess_options::grid_resolution, UpTo<unsigned>{1048576});
    use("k_init", &Options::k_init, &votess_options::k_init, UpTo<unsigned>{1024});
    use("chunk_size", &Options::chunk_size, &votess_options::chunk_size, UpTo<unsigned>{4294967295});
    use("follow", &Options::follow, &votess_options::follow, anything);
    use("instructions", &Options::instructions, &votess_options::instructions, anything);
    use("planar", &Options::planar, &votess_options::planar, anything);
}

}  // namespace votess
