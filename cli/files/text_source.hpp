// A text, front to back: a file, stdin, a file packed by gzip, or text in memory. Memory holds some pieces of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "files/inflate.hpp"
#include "files/input_file.hpp"

namespace clvotess {

class TextSource {
public:
    TextSource(const std::string& path, bool packed);
    // text: must outlive this. name: for messages.
    TextSource(std::string_view text, std::string name);
    TextSource(const TextSource&) = delete;
    TextSource& operator=(const TextSource&) = delete;

    // Appends about a MiB. Returns false at the end. Throws Failure for a damaged or hostile packed file.
    bool append(std::string& to);

    [[nodiscard]] const std::string& name() const noexcept { return name_; }
    // Returns the share of the file that was read; 0 where its size is unknown.
    [[nodiscard]] double fraction() const noexcept;
    // Returns the bytes of the text that were not read; nothing where that is unknown.
    [[nodiscard]] std::optional<std::uint64_t> rest() const noexcept;

private:
    bool append_unpacked(std::string& to);

    std::string name_;
    std::optional<InputFile> file_;
    std::optional<Inflater> inflater_;
    std::string_view text_;   // in memory, not yet read
    std::string packed_;      // the current piece of a packed file
    std::uint64_t read_ = 0;  // bytes of the file
    std::uint64_t unpacked_ = 0;
    bool begun_ = false;  // within a member of the packed file
    bool more_ = true;    // bytes of the file remain
};

// Returns the text from `begun` on, which was read before. Throws Failure for a line that is too long.
[[nodiscard]] std::string rest_of(TextSource& source, std::string begun = {});

}  // namespace clvotess
