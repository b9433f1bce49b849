// Floating point of 2304 bits: relative rounding so small that even a cell as thin as the smallest subnormal in a box
// of order one keeps a correct volume.
#pragma once

#include <boost/multiprecision/cpp_bin_float.hpp>

namespace votess::exact {

using WideFloat =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<2304, boost::multiprecision::digit_base_2>,
                                  boost::multiprecision::et_off>;

}  // namespace votess::exact
