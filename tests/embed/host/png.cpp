#include "png.hpp"

#include <stdexcept>
#include <vector>
#if VOTESS_HAVE_PNG
#include <png.h>
#endif

namespace host {

#if VOTESS_HAVE_PNG

void check_png() {}

void write_png(const std::string& file, std::span<const std::byte> rgba, std::uint32_t width, std::uint32_t height) {
    std::vector<std::byte> rgb;
    rgb.reserve(rgba.size() / 4 * 3);
    for (std::size_t i = 0; i < rgba.size(); ++i) {
        if (i % 4 != 3) rgb.push_back(rgba[i]);
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    if (!png_image_write_to_file(&image, file.c_str(), 0, rgb.data(), 0, nullptr)) {
        throw std::runtime_error(file + ": " + image.message);
    }
}

#else

void check_png() {
    throw std::runtime_error("--output: this program was built without libpng");
}

void write_png(const std::string&, std::span<const std::byte>, std::uint32_t, std::uint32_t) {
    check_png();
}

#endif

}  // namespace host
