// Where and when a run took place, and writing JSON files.
#pragma once

#include <string>
#include <string_view>

namespace bench {

void print_machine();
std::string machine_json();  // with the date

std::string in_quotes(std::string_view text);
void write_whole(const std::string& file, const std::string& text);  // or not at all: throws std::runtime_error

}  // namespace bench
