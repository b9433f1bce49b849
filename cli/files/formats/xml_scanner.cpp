#include "files/formats/xml_scanner.hpp"

#include <algorithm>

#include "files/limits.hpp"

namespace clvotess {
namespace {

constexpr std::string_view blanks = " \t\r\n";

std::string_view trimmed(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

}  // namespace

bool XmlScanner::next(XmlTag& tag) {
    for (;;) {
        at_ = text_.find('<', at_);
        if (at_ == std::string_view::npos) {
            at_ = text_.size();
            return false;
        }
        const std::string_view rest = text_.substr(at_);
        const std::string_view passed_end = rest.starts_with("<!--") ? "-->" : rest.starts_with("<?") ? "?>" : "";
        if (passed_end.empty()) {
            if (rest.starts_with("<!")) throw broken();
            break;
        }
        const auto end = rest.find(passed_end);
        if (end == std::string_view::npos) throw broken();
        at_ += end + passed_end.size();
    }
    // A value in quotes may hold the end mark.
    std::size_t end = at_ + 1;
    const std::size_t last = std::min(text_.size(), at_ + longest_line);
    for (char quote = 0; end < last && (quote != 0 || text_[end] != '>'); ++end) {
        const char c = text_[end];
        if (quote == 0 && (c == '"' || c == '\'')) {
            quote = c;
        } else if (c == quote) {
            quote = 0;
        }
    }
    if (end >= last) throw broken();
    std::string_view body = trimmed(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    tag = {};
    tag.end = at_;
    if (body.starts_with('/')) {
        tag.closes = true;
        tag.name = trimmed(body.substr(1));
        return true;
    }
    tag.opens = true;
    if (body.ends_with('/')) {
        tag.closes = true;
        body = trimmed(body.substr(0, body.size() - 1));
    }
    const auto name_end = std::min(body.find_first_of(blanks), body.size());
    tag.name = body.substr(0, name_end);
    body = trimmed(body.substr(name_end));
    while (!body.empty()) {
        const auto equals = body.find('=');
        if (equals == std::string_view::npos) throw broken();
        const std::string_view key = trimmed(body.substr(0, equals));
        body = trimmed(body.substr(equals + 1));
        if (body.empty() || (body[0] != '"' && body[0] != '\'')) throw broken();
        const auto value_end = body.find(body[0], 1);
        if (value_end == std::string_view::npos) throw broken();
        tag.attributes[key] = body.substr(1, value_end - 1);
        body = trimmed(body.substr(value_end + 1));
    }
    return true;
}

std::string_view XmlScanner::content(std::size_t from) const {
    const auto end = text_.find('<', from);
    if (end == std::string_view::npos) throw broken();
    return trimmed(text_.substr(from, end - from));
}

}  // namespace clvotess
