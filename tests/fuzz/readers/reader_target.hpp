// Functions of reader_target.cpp for standalone.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

// Chooses the reader by name. Returns false for an unknown one. With libFuzzer $VOTESS_FUZZ_READER names it.
bool choose_reader(const std::string& name);
// Returns all names, with blanks between them.
std::string reader_names();

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
