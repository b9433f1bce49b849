// Where a cell ends at first: at the walls of the box. The .comp declares `push`, with extent and bounded, before.
//
// Where seeds are known up to bounds alone, a cell that comes near them is not certified, wherever the wall is. But in a
// power diagram a cell need not hold its seed, and one that is cut off in a larger box with images may have all of its
// interior beyond it. In a periodic domain no cell reaches farther from its seed than half of the diagonal of the domain, for
// the seed's own images, nor along axes that are not periodic farther than the domain; so the wall is put beyond that.
#ifndef VOTESS_CLIP_FIRST_WALLS_GLSL
#define VOTESS_CLIP_FIRST_WALLS_GLSL

#include "clip/relative_to_seed.glsl"
#include "numbers/weights.glsl"

// The distance of wall i: 0 to 5 are xmin, xmax, ymin, ymax, zmin, zmax.
real start_wall(uint i) {
    const uint axis = i / 2u;
    const bool upper = (i & 1u) != 0u;
    if (weighted != 0u && ((push.bounded >> (upper ? axis + 3u : axis)) & 1u) != 0u)
        return real(4) * difference(max64(push.extent[0], max64(push.extent[1], push.extent[2])), uvec2(0));
    const uvec2 p = axis == 0u ? px : (axis == 1u ? py : pz), side = push.extent[axis];
    return difference(upper ? side : p, upper ? p : uvec2(0));
}

#endif
