#include "core/progress.hpp"

#include "votess/progress.hpp"

namespace votess {
namespace {

struct OfThread {
    Stoppable* stoppable = nullptr;
    bool may_call = false;
};
thread_local OfThread of_thread;

}  // namespace

// The callback may make calls of its own. They must not check this one.
bool Progress::call(double fraction) {
    fraction_ = std::max(fraction_, fraction);
    const Stoppable::Scope none(nullptr, false);
    return callback_(fraction_);
}

bool Progress::going_on(double fraction) {
    if (!callback_) return true;
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < interval) {
        fraction_ = std::max(fraction_, fraction);
        return true;
    }
    last_ = now;
    return call(fraction);
}

void Progress::report(double fraction) {
    if (!callback_) return;
    last_ = std::chrono::steady_clock::now();
    require(call(fraction));
}

ProgressCallback Progress::within(const Share& share) {
    if (!callback_) return {};
    return [this, share](double fraction) {
        last_ = std::chrono::steady_clock::now();
        return call(share.at(fraction));
    };
}

void Progress::require(bool going_on) {
    if (!going_on) throw Error(ErrorCode::cancelled, "cancelled by the progress callback");
}

Stoppable::Scope::Scope(Stoppable* to, bool may_call) noexcept
    : outer_(of_thread.stoppable), outer_may_call_(of_thread.may_call) {
    of_thread = {to, may_call};
}

Stoppable::Scope::~Scope() {
    of_thread = {outer_, outer_may_call_};
}

Stoppable::Stoppable(Progress& progress, const Share& stage)
    : progress_(progress),
      stage_(stage),
      scope_(progress ? this : of_thread.stoppable, progress || of_thread.may_call) {}

Stoppable::~Stoppable() = default;

Stoppable* Stoppable::current() noexcept {
    return of_thread.stoppable;
}

Share Stoppable::stage() noexcept {
    return of_thread.stoppable == nullptr ? Share{} : of_thread.stoppable->stage_;
}

ProgressCallback Stoppable::within(const Share& share) {
    return of_thread.stoppable == nullptr ? ProgressCallback{} : of_thread.stoppable->progress_.within(share);
}

void Stoppable::enter_stage(const Share& share) noexcept {
    if (of_thread.stoppable != nullptr) of_thread.stoppable->stage_ = share;
}

void Stoppable::check(double fraction) {
    Progress::require(!stopped_.load(std::memory_order_relaxed));
    if (!of_thread.may_call) return;
    try {
        Progress::require(progress_.going_on(fraction));
    } catch (...) {  // also for exceptions of the callback
        stopped_ = true;
        throw;
    }
}

void check_stop() {
    if (Stoppable* const own = of_thread.stoppable) own->check(0);
}

void report_stage(std::size_t done, std::size_t total) {
    if (Stoppable* const own = of_thread.stoppable) own->check(own->stage_.at(done, total));
}

struct ProgressScope::State {
    explicit State(ProgressCallback callback) : progress(std::move(callback)), stoppable(progress, {}) {}
    Progress progress;
    Stoppable stoppable;
};
ProgressScope::ProgressScope(ProgressCallback callback) : state_(std::make_unique<State>(std::move(callback))) {}
ProgressScope::~ProgressScope() = default;

}  // namespace votess
