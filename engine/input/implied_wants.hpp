// Arrays that others need.
#pragma once

#include "votess/votess.hpp"

namespace votess {

// Returns options.want with the arrays that these, min_face and min_area need.
inline Want with_implied(const Options& options) {
    Want want = options.want;
    want.areas |= options.min_face > 0 || options.min_area > 0;
    want.vertices |= want.faces;
    want.neighbors |= want.areas || want.normals || want.vertices;
    return want;
}

// Whether lists, volumes, centroids, counts and areas are not enough: whole polytopes are needed.
inline bool needs_polytopes(const Want& want) {
    return want.vertices || want.normals || want.surfaces || want.radii;
}

// Whether coordinates of vertices are needed.
inline bool needs_geometry(const Want& want) {
    return want.volumes || want.centroids || want.areas || want.surfaces || want.radii || want.vertices;
}

}  // namespace votess
