// The walk compiled for processors with AVX-512.
// What stands before the pragma is compiled for any processor: functions of
// headers are shared with other files.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cpu/hierarchy.hpp"
#include "cpu/neighborhood.hpp"
#include "cpu/star.hpp"
#include "cpu/star_kernels.hpp"
#include "cpu/window.hpp"
#include "exact/corner.hpp"
#include "exact/predicate.hpp"
#include "exact/vertex.hpp"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx512bw,bmi,bmi2,fma,lzcnt,popcnt,prefer-vector-width=256")
#include "cpu/star_walk.hpp"

namespace votess::cpu {

struct Avx512 {};
template class StarWalk<Avx512>;

std::unique_ptr<Star> make_star_avx512(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Avx512>>(seeds, hierarchy, star_kernels("avx512"));
}

}  // namespace votess::cpu
#pragma GCC pop_options
#endif
