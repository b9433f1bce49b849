#include <algorithm>

#include "cpu/star.hpp"

namespace votess::cpu {

bool StarHints::begin(const StarHints& last) {
    used_ = 0;
    seeds_.clear();
    wait_ = std::max(0, last.wait_ - 1);
    next_wait_ = last.useful_ ? 0 : last.next_wait_;
    useful_ = last.used_ > 0;
    return last.wait_ == 0;
}

void StarHints::give_up() {
    used_ = 0;
    seeds_.clear();
    useful_ = false;
    wait_ = next_wait_;
    next_wait_ = std::clamp(2 * next_wait_, 1, longest_wait);
}

}  // namespace votess::cpu
