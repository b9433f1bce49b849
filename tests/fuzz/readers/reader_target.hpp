// What reader_target.cpp offers beside the functions that libFuzzer calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

// The reader that is fed, by name; false when there is none. libFuzzer takes it from $VOTESS_FUZZ_READER.
bool choose_reader(const std::string& name);
// All names, a blank between two.
std::string reader_names();

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
