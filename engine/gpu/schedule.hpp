// Which cells of a part the device is asked for, in which pieces: where it rarely succeeds it costs more than it
// spares.
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
    bool trial = false;  // its outcome decides on the next piece
    bool second_tier = true;
    bool ties = false;  // the device decides them
};

// Windows of a fixed number of seeds are clipped or left to the CPU. A window is judged by its own first cells, the
// trial, or by windows whose cells are all done when it begins. So the answer does not depend on the sizes of pieces,
// which follow the device's speed.
class Schedule {
public:
    static constexpr std::uint32_t trial_cells = 2048;

    Schedule(std::uint32_t seeds, std::uint32_t window);

    // The next piece, of at most so many cells on the device; nothing at the end. When a window begins, the pieces of
    // all windows but the last must have been noted, and a trial before whatever follows it.
    [[nodiscard]] std::optional<Piece> next(std::uint32_t most);
    // True when a trial met ties: it begins anew, and they are decided from here on.
    [[nodiscard]] bool repeat_with_ties(const Piece& piece, std::size_t uncertain);
    // What became of a piece on the device: its cells, those that the first tier left, those left to the CPU, and those
    // of the latter that are uncertain.
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
    std::vector<Tally> tallies_;            // of the windows begun
    std::uint32_t skip_ = 0, skipped_ = 0;  // windows to leave to the CPU after a hopeless one, and those left
    bool trial_ = false, leave_ = false;    // of the present window
    bool second_tier_ = true;               // worth its time
    bool ties_ = false;                     // many were met
    bool repeated_ = false;                 // the next piece is a trial that begins anew
};

}  // namespace votess::gpu
