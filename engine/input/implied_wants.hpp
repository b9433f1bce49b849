// What options mean beyond their words.
#pragma once

#include "votess/votess.hpp"

namespace votess {

// options.want, and the arrays that these, min_face and min_area need.
inline Want with_implied(const Options& options) {
    Want want = options.want;
    want.areas |= options.min_face > 0 || options.min_area > 0;
    want.vertices |= want.faces;
    want.neighbors |= want.areas || want.normals || want.vertices;
    return want;
}

// What needs polytopes, and not only lists, volumes, centroids, counts and areas.
inline bool needs_polytopes(const Want& want) {
    return want.vertices || want.normals || want.surfaces || want.radii;
}

// Whether vertices must be placed, and cells measured.
inline bool needs_geometry(const Want& want) {
    return want.volumes || want.centroids || want.areas || want.surfaces || want.radii || want.vertices;
}

}  // namespace votess
