// What options mean beyond their words.
#pragma once

#include "votess/votess.hpp"

namespace votess {

inline void add_implied(Options& options) {
    Want& want = options.want;
    want.areas |= options.min_face > 0;
    want.vertices |= want.faces;
    options.walls |= want.faces;
    want.neighbors |= want.areas || want.normals || want.vertices;
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
