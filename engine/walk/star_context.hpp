// Includes for the walk. Files that compile the walk for one instruction set include this before they choose the set.
// Functions of headers are shared with files that run on any processor.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "exact/corner.hpp"
#include "exact/predicate.hpp"
#include "exact/tied_seeds.hpp"
#include "index/hierarchy.hpp"
#include "index/seed_images.hpp"
#include "kernels/star_kernels.hpp"
#include "polytope/cell.hpp"
#include "walk/neighborhood.hpp"
#include "walk/star.hpp"
#include "walk/star_bounds.hpp"
#include "walk/window.hpp"
