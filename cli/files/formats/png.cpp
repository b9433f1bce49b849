#include "files/formats/png.hpp"

#include <vector>

#include "failure.hpp"
#if VOTESS_HAVE_PNG
#include <png.h>
#endif

namespace clvotess {

#if VOTESS_HAVE_PNG

void check_png() {}

std::string to_png(const votess::Picture& picture) {
    bool opaque = true;
    for (std::size_t i = 3; i < picture.pixels.size(); i += 4) opaque = opaque && picture.pixels[i] == 255;
    std::vector<std::uint8_t> pixels;  // without alpha where all pixels are opaque
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        if (!opaque || i % 4 != 3) pixels.push_back(picture.pixels[i]);
    }
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = picture.width;
    image.height = picture.height;
    image.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::string bytes(size, '\0');
    if (!png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr)) {
        throw runtime_failure(std::string("cannot make a PNG file: ") + image.message);
    }
    bytes.resize(size);
    return bytes;
}

#else

void check_png() {
    throw bad_input("--image: this clvotess was built without libpng: build it where libpng-dev is installed");
}

std::string to_png(const votess::Picture&) {
    check_png();
    return {};
}

#endif

}  // namespace clvotess
