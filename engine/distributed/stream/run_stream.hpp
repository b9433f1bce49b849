// A stream of seeds in, a stream of rows out.
#pragma once

#include "input/settled.hpp"
#include "votess/stream.hpp"

namespace votess::stream {

// whole: without seeds.
[[nodiscard]] StreamResult run_stream(StreamSource& source, StreamSink& sink, const Settled& whole,
                                      const StreamOptions& stream);

}  // namespace votess::stream
