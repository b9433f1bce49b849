// The progress callback of a thread, for functions that take none.
#include "core/progress.hpp"

#include "c/handles.hpp"

namespace votess::c {
namespace {

struct Watch {
    votess_progress_callback callback = nullptr;
    void* user = nullptr;
};
thread_local Watch watch_of_thread;

}  // namespace

void call_watched(void (*function)(void*), void* data) {
    const Watch watch = watch_of_thread;
    if (watch.callback == nullptr) return function(data);
    Progress progress(watching(watch.callback, watch.user));
    const Stoppable stoppable(progress, {});
    function(data);
}

}  // namespace votess::c

void votess_set_progress(votess_progress_callback progress, void* user) {
    votess::c::watch_of_thread = {progress, user};
}
