#include "progress.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "core/system.hpp"

namespace clvotess {

Progress::Progress(bool enabled, Clock::time_point run_began)
    : quiet_(!enabled), enabled_(enabled && votess::system::stderr_is_terminal()), run_began_(run_began) {}

Progress::~Progress() {
    if (drawn_) std::fputs("\r\x1b[K", stderr);
}

void Progress::say(const std::string& line) {
    if (quiet_) return;
    if (drawn_) std::fputs("\r\x1b[K", stderr);
    std::fprintf(stderr, "%s\n", line.c_str());
}

void Progress::show(double fraction) {
    constexpr int width = 40;
    if (!enabled_ || Clock::now() - run_began_ < std::chrono::seconds(1)) return;
    fraction = std::clamp(fraction, 0.0, 1.0);
    const int filled = static_cast<int>(fraction * width);
    const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
    std::string left;
    // The first percent is too short for an estimate.
    if (fraction > 0.01) {
        const std::chrono::duration<double> since = Clock::now() - run_began_;
        const auto seconds = static_cast<long>(std::lround(since.count() * (1 - fraction) / fraction));
        left = seconds < 100 ? std::to_string(seconds) + " s left" : std::to_string((seconds + 30) / 60) + " min left";
    }
    if (!stage_.empty()) left += (left.empty() ? "" : ", ") + stage_;
    std::fprintf(stderr, "\r[%s] %3d %% %s\x1b[K", bar.c_str(), static_cast<int>(fraction * 100), left.c_str());
    drawn_ = true;
}

}  // namespace clvotess
