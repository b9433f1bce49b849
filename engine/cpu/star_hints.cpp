#include <algorithm>

#include "cpu/star.hpp"

namespace votess::cpu {

bool StarHints::begin(const StarHints* last) {
    used_ = 0;
    seeds_.clear();
    wait_ = last != nullptr ? std::max(0, last->wait_ - 1) : 0;
    next_wait_ = last != nullptr ? last->next_wait_ : 1;
    return last == nullptr || last->wait_ == 0;
}

void StarHints::give_up() {
    used_ = 0;
    seeds_.clear();
    wait_ = next_wait_;
    next_wait_ = std::min(2 * next_wait_, longest_wait);
}

}  // namespace votess::cpu
