#include <array>

#include "arguments/arguments.hpp"
#include "failure.hpp"
#include "files/numbers.hpp"
#include "options.hpp"
#include "run/frames.hpp"

namespace clvotess {

FrameRange read_frame_range(const std::string& text) {
    FrameRange range;
    range.text = text;
    if (text == "all") return range;
    if (text == "last") {
        range.last = true;
        return range;
    }
    const auto refuse = [&] {
        return bad_input("--frames must be all, last or a:b:c, frames a to b - 1 in steps of c, counted from 0, not " +
                         in_quotes(text));
    };
    const auto parts = split(text, ':');
    if (parts.size() < 2 || parts.size() > 3) throw refuse();
    std::array<std::optional<std::uint64_t>, 3> numbers;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        numbers[k] = read_uint64(parts[k]);
        if (!numbers[k] && !parts[k].empty()) throw refuse();
    }
    range.begin = numbers[0].value_or(0);
    range.end = numbers[1];
    range.step = numbers[2].value_or(1);
    if (range.step == 0 || (range.end && *range.end <= range.begin)) throw refuse();
    return range;
}

}  // namespace clvotess
