// JSON, read in place: a value is the part of the text that holds it. Nothing is copied or kept.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace clvotess {

class Json {
public:
    // Checks a whole document. Throws Failure, whose message begins with `name:`.
    [[nodiscard]] static Json read(std::string_view text, const std::string& name);

    // Returns the last member with this name, as it is written in the text; nothing if this is not an object.
    [[nodiscard]] std::optional<Json> find(std::string_view name) const;
    // Returns the values of an array; none if this is not an array.
    [[nodiscard]] std::vector<Json> items() const;
    [[nodiscard]] std::optional<double> number() const;
    [[nodiscard]] std::optional<std::uint64_t> whole() const;
    [[nodiscard]] std::string_view text() const { return text_; }  // with quotes

private:
    explicit Json(std::string_view text) : text_(text) {}

    std::string_view text_;
};

}  // namespace clvotess
