#include "progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace clvotess {

Progress::Progress(bool enabled, Clock::time_point run_began)
    : enabled_(enabled && isatty(STDERR_FILENO) == 1), run_began_(run_began) {}

Progress::~Progress() {
    if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void Progress::show(double fraction) {
    constexpr int width = 40;
    if (!enabled_ || Clock::now() - run_began_ < std::chrono::seconds(1)) return;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const int filled = static_cast<int>(fraction * width);
    const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
    std::fprintf(stderr, "\r[%s] %3d %%", bar.c_str(), static_cast<int>(fraction * 100));
    drawn_ = true;
}

}  // namespace clvotess
