// Results whose arrays are used again: when the last handle of a Tessellation is gone, its Tessellator takes it back.
#pragma once

#include <memory>
#include <mutex>
#include <utility>

#include "result/result.hpp"

namespace votess::detail {

// Handles may be dropped by any thread, and may outlive the pool. Nobody waits for the mutex: in a child made by fork()
// while another thread held it, that would be for ever.
class ResultPool : public std::enable_shared_from_this<ResultPool> {
public:
    // Empty, or with the arrays of an earlier run.
    [[nodiscard]] Result take() {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        return lock ? std::exchange(spare_, {}) : Result();
    }
    [[nodiscard]] std::shared_ptr<const Result> share(Result result) {
        auto owned = std::make_unique<Result>(std::move(result));
        // Should this throw, the deleter has run.
        return {owned.release(), [pool = weak_from_this()](Result* dropped) {
                    const std::unique_ptr<Result> last(dropped);
                    if (const auto alive = pool.lock()) alive->give_back(*last);
                }};
    }

private:
    // One spare is enough for a caller that holds a result while the next one is made.
    void give_back(Result& result) noexcept {
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock) std::swap(spare_, result);
    }

    std::mutex mutex_;
    Result spare_;
};

}  // namespace votess::detail
