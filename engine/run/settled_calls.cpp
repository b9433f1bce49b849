// The public functions that settle a run for other folders.
#include "diagram/diagram_state.hpp"
#include "distributed/stream/run_stream.hpp"
#include "fit/fit_volumes.hpp"
#include "input/hull_of_parts.hpp"
#include "input/settle.hpp"
#include "votess/diagram.hpp"

namespace votess {

Diagram::Diagram() : Diagram(std::span<const double>{}) {}
Diagram::Diagram(std::span<const double> points, const Options& options)
    : state_(detail::make_state(options.progress, [&] {
          return settle({points, {}}, options);
      })) {}

VolumeFit fit_volumes(std::span<const double> points, std::span<const double> targets, const Options& options,
                      const FitOptions& fit_options) {
    return fit::fit_volumes(
        [&] {
            return settle({points, {}}, options);
        },
        points.size() / (options.planar ? 2 : 3), targets, fit_options);
}

StreamSource::~StreamSource() = default;
StreamSink::~StreamSink() = default;
void StreamSink::begin(const StreamHead&) {}

StreamResult tessellate_stream(StreamSource& source, StreamSink& sink, const Options& options,
                               const StreamOptions& stream) {
    if (stream.hull) (void)HullOfParts(region_of(options));  // its refusal comes first
    return stream::run_stream(source, sink, settle(options), stream);
}

}  // namespace votess
