#include "files/inflate.hpp"

#include <algorithm>
#include <new>

#include "failure.hpp"
#include "files/limits.hpp"
#include "interrupt.hpp"

namespace clvotess {

Inflater::Inflater(std::string_view packed, Frame frame) : rest_(packed) {
    constexpr int gzip_alone = 16;
    const int window = frame == Frame::none ? -MAX_WBITS : MAX_WBITS + gzip_alone;
    if (inflateInit2(&stream_, window) != Z_OK) throw std::bad_alloc();
}

std::size_t Inflater::read(char* to, std::size_t room) {
    constexpr std::size_t piece = std::size_t{1} << 22;
    std::size_t done = 0;
    while (done < room && !ended_) {
        throw_if_interrupted();
        if (stream_.avail_in == 0) {
            const std::size_t given = std::min(rest_.size(), piece);
            stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(rest_.data()));
            stream_.avail_in = static_cast<uInt>(given);
            rest_.remove_prefix(given);
        }
        const auto some = static_cast<uInt>(std::min(room - done, piece));
        stream_.next_out = reinterpret_cast<Bytef*>(to + done);
        stream_.avail_out = some;
        const int state = inflate(&stream_, Z_NO_FLUSH);
        done += some - stream_.avail_out;
        ended_ = state == Z_STREAM_END;
        damaged_ = state != Z_OK && state != Z_BUF_ERROR && !ended_;
        if (state != Z_OK && !ended_) break;
    }
    return done;
}

void Inflater::restart() {
    inflateReset(&stream_);
    ended_ = false;
}

void check_unpacked(std::uint64_t size, std::uint64_t unpacked, const std::string& name) {
    if (unpacked <= max_unpacked(size)) return;
    throw bad_input(name + ": its " + std::to_string(size) + " bytes unpack to more than the limit of " +
                    std::to_string(max_unpacked(size)) + ": unpack the file first");
}

}  // namespace clvotess
