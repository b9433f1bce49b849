// The cells of a frame, and all that options make of them: fits, densities, zones, alpha complexes, checks, pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>
#include <votess/alpha.hpp>
#include <votess/votess.hpp>

#include "arguments/arguments.hpp"
#include "domain.hpp"
#include "progress.hpp"
#include "read/input.hpp"
#include "summary.hpp"
#include "write/output.hpp"

namespace clvotess {

struct Cells {
    Input input;  // with --only these points alone, as `carried` and `radii`
    DomainFrom domain_from;
    std::vector<InputColumn> carried;
    std::span<const double> radii;  // a view into the input, or the next
    InputColumn radii_of_rows;
    std::vector<std::int64_t> all_ids;  // of all points, with --only
    votess::Tessellation tessellation;
    std::optional<votess::AlphaComplex> alpha;
    std::optional<Summary::Fit> fit;
    std::optional<votess::VerifyReport> verified;
    std::string image;         // the bytes of a .png
    double image_seconds = 0;  // of drawing

    [[nodiscard]] bool failed() const { return verified && !verified->passed; }
    // Returns views of this object and the arguments.
    [[nodiscard]] OutputData output(const Arguments& arguments, FramePlace place) const;
};

// Makes the cells of these points. tessellator: reused from frame to frame; may be null. After a failed check there is
// no picture. Throws Failure.
[[nodiscard]] Cells make_cells(const Arguments& arguments, Input input, votess::Tessellator* tessellator,
                               const Watch& watch);

}  // namespace clvotess
