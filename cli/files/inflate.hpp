// Unpacks deflate: gzip files and members of zip archives.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace clvotess {

class Inflater {
public:
    enum class Frame { none, gzip };  // format around the packed data

    // packed: must outlive this.
    Inflater(std::string_view packed, Frame frame);
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { inflateEnd(&stream_); }

    // Unpacks the next bytes and returns their number. It is less than `room` at the end of the packed data, and where
    // they are damaged or incomplete. Throws Interrupted soon after a signal.
    std::size_t read(char* to, std::size_t room);
    // Returns whether the packed data ended regularly.
    [[nodiscard]] bool ended() const noexcept { return ended_; }
    // Returns whether bytes follow the end.
    [[nodiscard]] bool has_more() const noexcept { return stream_.avail_in > 0 || !rest_.empty(); }
    // Continues with the packed data that follow.
    void restart();
    // Continues with more packed data, when has_more() is false. They must outlive their use.
    void go_on(std::string_view packed) noexcept { rest_ = packed; }
    // Returns whether the packed data are not those of zlib.
    [[nodiscard]] bool damaged() const noexcept { return damaged_; }

private:
    z_stream stream_{};
    std::string_view rest_;  // not yet passed to zlib
    bool ended_ = false, damaged_ = false;
};

// Throws Failure when `unpacked`, the bytes that a file of `size` bytes unpacks to, exceeds max_unpacked().
void check_unpacked(std::uint64_t size, std::uint64_t unpacked, const std::string& name);

}  // namespace clvotess
