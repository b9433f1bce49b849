// Unpacks what deflate has packed: gzip and the members of zip archives.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace clvotess {

class Inflater {
public:
    enum class Frame { none, gzip };  // what surrounds the packed data

    // packed: must outlive this.
    Inflater(std::string_view packed, Frame frame);
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { inflateEnd(&stream_); }

    // Unpacks the next bytes and returns how many: fewer than `room` at the end of the packed data, or where they are
    // damaged or end too early. Throws Interrupted soon after a signal.
    std::size_t read(char* to, std::size_t room);
    // Whether the end of the packed data was reached, as it should be.
    [[nodiscard]] bool ended() const noexcept { return ended_; }
    // Whether bytes follow behind the end.
    [[nodiscard]] bool has_more() const noexcept { return stream_.avail_in > 0 || !rest_.empty(); }
    // Goes on with packed data that follow.
    void restart();

private:
    z_stream stream_{};
    std::string_view rest_;  // not yet given to zlib
    bool ended_ = false;
};

// Returns what all members of a file hold, one after the other. Throws Failure, which names the file, when it is
// damaged or unpacks to more than max_unpacked().
[[nodiscard]] std::string gunzip(std::string_view packed, const std::string& name);

// Throws Failure when a file of `size` bytes unpacks to `unpacked` bytes, more than max_unpacked().
void check_unpacked(std::uint64_t size, std::uint64_t unpacked, const std::string& name);

}  // namespace clvotess
