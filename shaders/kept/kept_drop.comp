// kept: makes all kept cells pending where the judgment failed, or where too many others are pending to gain by it.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "invocations/index.glsl"
#include "shared/interface.h"
#include "shared/layout.h"

layout(push_constant) uniform Push { KeptPush push; };

#include "shared/chunk.glsl"

void main() {
    const uint cell = linear_invocation();
    if (cell >= push.cell_count || (chunk.kept_failed == 0u && chunk.kept_pending <= push.max_pending)) return;
    if ((word_of(WORDS_KEPT, cell) & KEPT_HELD) == 0u) return;
    of_cells[word_at(WORDS_KEPT, cell)] = 0u;
    of_cells[word_at(WORDS_INFO, cell)] = STATUS_CANDIDATES_EXHAUSTED;
}
