// PNG files, through libpng.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace host {

// Throws where the program was built without libpng.
void check_png();
// rgba: width * height * 4 bytes, of which the fourth is not written.
void write_png(const std::string& file, std::span<const std::byte> rgba, std::uint32_t width, std::uint32_t height);

}  // namespace host
