#include "pipeline.hpp"

#include <chrono>

#include "input/options.hpp"

namespace votess {
namespace {

// Adds, because an engine may have put there what it did of a stage within another one.
template <class Stage>
void timed(double& seconds, Stage stage) {
    const auto begin = std::chrono::steady_clock::now();
    stage();
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

detail::Result run_pipeline(const Points& points, const Options& options, Engine& engine, detail::Result arrays) {
    detail::Result result;
    StageSeconds& seconds = result.stats.seconds;
    timed(seconds.total, [&] {
        timed(seconds.upload, [&] {
            Job job = validate(points, options);
            job.arrays = &arrays;
            engine.upload(job);
        });
        timed(seconds.sort, [&] { engine.sort(); });
        timed(seconds.knn, [&] { engine.knn(); });
        timed(seconds.clip, [&] { engine.clip(); });
        timed(seconds.fallback, [&] { engine.fallback(); });
        timed(seconds.download, [&] { engine.download(result); });
    });
    return result;
}

}  // namespace votess
