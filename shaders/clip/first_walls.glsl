// The box that a cell starts as. The .comp declares `push`, with extent and bounded, before.
//
// Where seeds are known within bounds only, a cell that comes near the bounds is not certified, wherever the wall is.
// But in a power diagram a cell may not hold its seed, and all of its interior may lie beyond a box with images. In a
// periodic domain the seed's own images keep a cell within half of the domain's diagonal, and along other axes it ends
// with the domain. So the wall is beyond that, and beyond the tilt, which is less than a quarter of the longest side.
#ifndef VOTESS_CLIP_FIRST_WALLS_GLSL
#define VOTESS_CLIP_FIRST_WALLS_GLSL

#include "clip/relative_to_seed.glsl"
#include "numbers/weights.glsl"

// Returns the distance of wall i from the center: 0 to 5 are xmin, xmax, ymin, ymax, zmin, zmax. It is negative where the
// center lies beyond the wall.
real start_wall(uint i) {
    const uint axis = i / 2u;
    const bool upper = (i & 1u) != 0u;
    if (weighted != 0u && ((push.bounded >> (upper ? axis + 3u : axis)) & 1u) != 0u)
        return real(4) * difference(max64(push.extent[0], max64(push.extent[1], push.extent[2])), uvec2(0));
    const uvec2 c = axis == 0u ? cx : (axis == 1u ? cy : cz), side = push.extent[axis];
    return difference(upper ? side : c, upper ? c : uvec2(0));
}

#endif
