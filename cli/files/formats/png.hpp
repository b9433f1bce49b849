// PNG files, written by libpng.
#pragma once

#include <string>
#include <votess/picture.hpp>

namespace clvotess {

// Throws Failure when this program was built without libpng.
void check_png();
// Returns the bytes of a PNG file.
[[nodiscard]] std::string to_png(const votess::Picture& picture);

}  // namespace clvotess
