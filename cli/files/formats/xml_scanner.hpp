// The tags of an XML text, one after the other: as much XML as VTK's files have. Comments and declarations are passed.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "failure.hpp"

namespace clvotess {

struct XmlTag {
    std::string_view name;
    bool opens = false;   // <name ...>
    bool closes = false;  // </name>; <name ... /> does both
    std::map<std::string_view, std::string_view> attributes;
    std::size_t end = 0;  // of the tag: where what it holds begins

    [[nodiscard]] std::string_view operator[](std::string_view attribute) const {
        const auto found = attributes.find(attribute);
        return found == attributes.end() ? std::string_view{} : found->second;
    }
};

class XmlScanner {
public:
    // name: for messages.
    XmlScanner(std::string_view text, const std::string& name) : text_(text), name_(name) {}

    // The next tag; false at the end of the text.
    [[nodiscard]] bool next(XmlTag& tag);
    // The text from `from`, the end of a tag, to the next tag.
    [[nodiscard]] std::string_view content(std::size_t from) const;

private:
    [[nodiscard]] Failure broken() const { return bad_input(name_ + ": the XML is damaged or ends too early"); }

    std::string_view text_;
    std::string name_;
    std::size_t at_ = 0;
};

}  // namespace clvotess
