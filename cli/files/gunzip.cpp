#include "files/gunzip.hpp"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "failure.hpp"
#include "interrupt.hpp"

namespace clvotess {
namespace {

struct Inflater {
    z_stream stream{};

    Inflater() {
        constexpr int gzip_only = 16;
        if (inflateInit2(&stream, MAX_WBITS + gzip_only) != Z_OK) throw std::bad_alloc();
    }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    ~Inflater() { inflateEnd(&stream); }
};

}  // namespace

std::string gunzip(std::string_view packed, const std::string& name) {
    constexpr std::size_t most_at_once = std::size_t{1} << 24;
    Inflater inflater;
    z_stream& stream = inflater.stream;
    std::string text;
    bool ended = false;
    while (!packed.empty() || !ended) {
        throw_if_interrupted();
        const std::size_t given = std::min(packed.size(), most_at_once), before = text.size();
        text.resize(before + std::max(most_at_once / 16, std::min(2 * given, most_at_once)));
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
        stream.avail_in = static_cast<uInt>(given);
        stream.next_out = reinterpret_cast<Bytef*>(text.data() + before);
        stream.avail_out = static_cast<uInt>(text.size() - before);
        const int state = inflate(&stream, Z_NO_FLUSH);
        packed.remove_prefix(given - stream.avail_in);
        text.erase(text.size() - stream.avail_out);
        ended = state == Z_STREAM_END;
        const bool going_on = state == Z_OK && (text.size() > before || stream.avail_in < given);
        if (!ended && !going_on) {
            throw bad_input(name + (state == Z_BUF_ERROR ? ": the file ends too early"
                                                         : ": not a file packed by gzip, or a damaged one"));
        }
        if (ended && !packed.empty()) inflateReset(&stream);
    }
    return text;
}

}  // namespace clvotess
