// What stands for the renderer in a build without it.
#include <votess/picture.hpp>

namespace votess {

Picture render(const Tessellation&, std::span<const double>, const PictureOptions&) {
    throw Error(ErrorCode::unsupported, "picture: this votess was built without the renderer (VOTESS_BUILD_PICTURES)");
}

}  // namespace votess
