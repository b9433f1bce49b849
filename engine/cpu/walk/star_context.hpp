// All that the walk uses. Files that compile it for one instruction set include this before they choose the set:
// functions of headers are shared with files that run on any processor.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "cpu/clip/cell.hpp"
#include "cpu/sort/hierarchy.hpp"
#include "cpu/sort/seed_images.hpp"
#include "cpu/walk/kernels/star_kernels.hpp"
#include "cpu/walk/neighborhood.hpp"
#include "cpu/walk/star.hpp"
#include "cpu/walk/star_bounds.hpp"
#include "cpu/walk/window.hpp"
#include "exact/corner.hpp"
#include "exact/predicate.hpp"
#include "exact/vertex.hpp"
