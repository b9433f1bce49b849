// Which cells of a part go to the device, in which pieces. Where the device rarely succeeds it costs more than it
// saves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace votess::gpu {

// Consecutive sorted seeds.
struct Piece {
    std::uint32_t first = 0, count = 0;
    bool on_device = true;
    bool trial = false;  // its outcome decides about the next piece
    bool second_tier = true;
    bool ties = false;  // the device decides them
};

// A window of a fixed number of seeds is clipped or left to the CPU. Its first cells are a trial that decides, or
// windows that were done when it began. So the choice does not depend on the sizes of pieces, which follow the device's
// speed.
class Schedule {
public:
    static constexpr std::uint32_t trial_cells = 2048;

    Schedule(std::uint32_t seeds, std::uint32_t window);

    // Returns the next piece, of at most `most` cells on the device; nothing at the end. Call note() first for a trial,
    // and for the pieces of all windows except the last.
    [[nodiscard]] std::optional<Piece> next(std::uint32_t most);
    // Returns whether a trial met many ties. If so, it starts again, and the device decides ties from here on.
    [[nodiscard]] bool repeat_with_ties(const Piece& piece, std::size_t uncertain);
    // Counts of a piece that the device is done with: its cells, cells that the first tier left, cells left to the CPU,
    // and how many of these are uncertain.
    void note(const Piece& piece, std::size_t cells, std::size_t left_by_first, std::size_t left,
              std::size_t uncertain);

private:
    struct Tally {
        std::uint64_t cells = 0, left_by_first = 0, left = 0, uncertain = 0;
        bool second_tier = false, ties = false;
    };

    void begin_window();
    void judge(const Tally& tally);
    void judge_second_tier(const Tally& tally);

    std::uint32_t seeds_ = 0, window_ = 1, first_ = 0;
    std::vector<Tally> tallies_;            // of the windows so far
    std::uint32_t skip_ = 0, skipped_ = 0;  // windows to skip after a hopeless one, and skipped so far
    bool trial_ = false, leave_ = false;    // of the present window
    bool second_tier_ = true;               // is worth its time
    bool ties_ = false;                     // there are many
    bool repeated_ = false;                 // the next piece repeats a trial
};

}  // namespace votess::gpu
