#include "files/json.hpp"

#include <algorithm>

#include "failure.hpp"
#include "files/limits.hpp"
#include "files/numbers.hpp"

namespace clvotess {
namespace {

class JsonScanner {
public:
    JsonScanner(std::string_view text, std::string name) : text_(text), name_(std::move(name)) {}

    void skip_blanks() {
        while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
    }
    [[nodiscard]] bool take(char c) {
        skip_blanks();
        if (at_ == text_.size() || text_[at_] != c) return false;
        ++at_;
        return true;
    }
    [[nodiscard]] bool at_end() {
        skip_blanks();
        return at_ == text_.size();
    }

    // Skips a string and returns it without quotes.
    std::string_view string() {
        if (!take('"')) fail();
        const std::size_t begin = at_;
        while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
        if (at_ >= text_.size()) fail();
        return text_.substr(begin, at_++ - begin);
    }
    // Skips a value and returns it.
    std::string_view value(int depth = 0) {
        skip_blanks();
        const std::size_t begin = at_;
        if (depth == max_depth) fail();
        if (take('{')) {
            for (bool first = true; !take('}'); first = false) {
                if (!first && !take(',')) fail();
                string();
                if (!take(':')) fail();
                value(depth + 1);
            }
        } else if (take('[')) {
            for (bool first = true; !take(']'); first = false) {
                if (!first && !take(',')) fail();
                value(depth + 1);
            }
        } else if (at_ < text_.size() && text_[at_] == '"') {
            string();
        } else {
            at_ = std::min(text_.find_first_of(",]} \t\r\n", at_), text_.size());
            const std::string_view word = text_.substr(begin, at_ - begin);
            const bool is_number = !word.empty() && (word[0] == '-' || is_digit(word[0])) && read_double(word);
            if (!is_number && word != "true" && word != "false" && word != "null") fail();
        }
        return text_.substr(begin, at_ - begin);
    }

private:
    [[noreturn]] void fail() const {
        throw bad_input(name_ + ": its JSON is damaged after " + std::to_string(std::min(at_, text_.size())) +
                        " bytes");
    }

    std::string_view text_;
    std::string name_;
    std::size_t at_ = 0;
};

}  // namespace

Json Json::read(std::string_view text, const std::string& name) {
    JsonScanner scanner(text, name);
    const Json document(scanner.value());
    if (!scanner.at_end()) throw bad_input(name + ": its JSON goes on after the end of the first value");
    return document;
}

std::optional<Json> Json::find(std::string_view name) const {
    JsonScanner scanner(text_, {});
    std::optional<Json> found;
    if (!scanner.take('{')) return found;
    while (!scanner.take('}')) {
        (void)scanner.take(',');
        const std::string_view key = scanner.string();
        (void)scanner.take(':');
        const Json value(scanner.value());
        if (key == name) found = value;
    }
    return found;
}

std::vector<Json> Json::items() const {
    JsonScanner scanner(text_, {});
    std::vector<Json> found;
    if (!scanner.take('[')) return found;
    while (!scanner.take(']')) {
        (void)scanner.take(',');
        found.push_back(Json(scanner.value()));
    }
    return found;
}

std::optional<double> Json::number() const {
    return read_double(text_);
}

std::optional<std::uint64_t> Json::whole() const {
    return read_uint64(text_);
}

}  // namespace clvotess
