// The version of the library and its last error.
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <utility>

#include "c/handles.hpp"

namespace votess::c {
namespace {

static_assert(same(VOTESS_ERROR_INVALID_ARGUMENT, ErrorCode::invalid_argument));
static_assert(same(VOTESS_ERROR_OUT_OF_MEMORY, ErrorCode::out_of_memory));
static_assert(same(VOTESS_ERROR_CANCELLED, ErrorCode::cancelled));
static_assert(same(VOTESS_ERROR_UNSUPPORTED, ErrorCode::unsupported));
static_assert(same(VOTESS_ERROR_INTERNAL, ErrorCode::internal));
static_assert(same(VOTESS_ERROR_DEVICE_LOST, ErrorCode::device_lost));
static_assert(same(VOTESS_ERROR_INVALID_USE, ErrorCode::invalid_use));
static_assert(same(VOTESS_ERROR_STORAGE, ErrorCode::storage));
static_assert(same(VOTESS_ERROR_NO_THREADS, ErrorCode::no_threads));
static_assert(same(VOTESS_ERROR_NOT_CONVERGED, ErrorCode::not_converged));

constexpr std::uint64_t max_elements = 2147483647;
constexpr std::uint64_t addressable = std::numeric_limits<std::uint64_t>::max() / (3 * sizeof(double));

// What stands before a member of options here, where it is a member of a struct. Others are parameters: gap for
// PieceOptions::gap.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> structs{
    {{"Options", "options."},
     {"FitOptions", "fit_options."},
     {"PictureOptions", "picture_options."},
     {"RemeshOptions", "remesh_options."},
     {"StreamOptions", "stream."},
     {"SurfaceOptions", "surface_options."},
     {"SurfaceLloydOptions", "surface_lloyd_options."}}};

// The last failure of each thread. Of fixed size, so that a report of exhausted memory takes none.
thread_local char last_error[1024] = "";

}  // namespace

void copy_text(std::string_view text, char* out, std::size_t out_size) noexcept {
    if (out_size == 0) return;
    std::size_t length = text.size();
    if (length >= out_size) {
        length = out_size - 1;
        while (length > 0 && (static_cast<unsigned char>(text[length]) & 0xC0u) == 0x80u) --length;
    }
    std::copy_n(text.data(), length, out);
    out[length] = '\0';
}

void set_last_error(std::string_view message) noexcept {
    char text[2 * sizeof last_error];
    std::size_t size = 0;
    const auto put = [&](std::string_view part) {
        part = part.substr(0, sizeof text - size);
        size = static_cast<std::size_t>(std::ranges::copy(part, text + size).out - text);
    };
    while (!message.empty()) {
        const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
        const auto end = std::ranges::find_if_not(message, is_letter);
        const auto length = std::max<std::size_t>(static_cast<std::size_t>(end - message.begin()), 1);
        const std::string_view word = message.substr(0, length);
        message.remove_prefix(length);
        if (!word.ends_with("Options") || !message.starts_with("::")) {
            put(word);
            continue;
        }
        message.remove_prefix(2);
        const auto found = std::ranges::find(structs, word, &std::pair<std::string_view, std::string_view>::first);
        if (found != structs.end()) put(found->second);
    }
    copy_text({text, size}, last_error, sizeof last_error);
}

void set_internal_error(const char* message) noexcept {
    std::snprintf(last_error, sizeof last_error, "internal error, please report it: %s", message);
}

void require(const void* pointer, const char* name) {
    if (pointer == nullptr) refuse(std::string(name) + " is NULL");
}

void require_array(const void* array, std::uint64_t count, const char* name, const char* count_name) {
    if (count > max_elements)
        throw Error(count > addressable ? ErrorCode::invalid_argument : ErrorCode::unsupported,
                    std::string(count_name) + " is " + std::to_string(count) + ", too many at once: " + name +
                        " may have at most " + std::to_string(max_elements));
    if (array == nullptr && count != 0)
        refuse(std::string(name) + " is NULL but " + count_name + " is " + std::to_string(count));
}

void require_text_buffer(const char* buffer, std::size_t size, const char* name) {
    if (buffer == nullptr && size != 0) {
        refuse(std::string(name) + " is NULL but its size is " + std::to_string(size) + ": give 0");
    }
}

void require_struct_size(std::size_t size, std::size_t smallest, const char* name, const char* remedy) {
    if (size >= smallest && size <= VOTESS_LARGEST_STRUCT) return;
    const bool small = size < smallest;
    refuse(std::string(name) + " is " + std::to_string(size) + ", but the " + (small ? "smallest" : "largest") +
           " known is " + std::to_string(small ? smallest : VOTESS_LARGEST_STRUCT) + ": " + remedy);
}

}  // namespace votess::c

uint32_t votess_version(void) {
    return VOTESS_VERSION_MAJOR * 1000000u + VOTESS_VERSION_MINOR * 1000u + VOTESS_VERSION_PATCH;
}

const char* votess_version_string(void) {
    return VOTESS_VERSION_STRING;
}

const char* votess_last_error(void) {
    return votess::c::last_error;
}
