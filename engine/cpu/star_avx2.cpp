// The walk compiled for processors with AVX2.
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
#pragma GCC target("avx2,bmi,bmi2,fma,lzcnt,popcnt")
#include "cpu/star_walk.hpp"

namespace votess::cpu {

struct Avx2 {};
template class StarWalk<Avx2>;

std::unique_ptr<Star> make_star_avx2(const SortedSeeds& seeds, const Hierarchy& hierarchy) {
    return std::make_unique<StarWalk<Avx2>>(seeds, hierarchy, star_kernels("avx2"));
}

}  // namespace votess::cpu
#pragma GCC pop_options
#endif
