#include "thread_pool.hpp"

#include <chrono>

namespace votess {

ThreadPool::ThreadPool(unsigned threads) {
    try {
        for (unsigned w = 1; w < threads; ++w) workers_.emplace_back([this, w] { serve(w); });
    } catch (...) {
        {
            std::lock_guard lock(mutex_);
            quit_ = true;
        }
        start_.notify_all();
        for (auto& t : workers_) t.join();
        throw;
    }
}

ThreadPool::~ThreadPool() {
    {
        std::lock_guard lock(mutex_);
        quit_ = true;
    }
    start_.notify_all();
    for (auto& t : workers_) t.join();
}

void ThreadPool::serve(unsigned worker) {
    std::uint64_t seen = 0;
    for (;;) {
        {
            std::unique_lock lock(mutex_);
            start_.wait(lock, [&] { return quit_ || job_ != seen; });
            if (quit_) return;
            seen = job_;
        }
        work(worker);
        std::lock_guard lock(mutex_);
        if (--busy_ == 0) done_.notify_one();
    }
}

void ThreadPool::work(unsigned worker) {
    try {
        while (!cancelled_.load(std::memory_order_relaxed)) {
            if (worker == 0 && *watch_ && !(*watch_)(std::min(next_.load(std::memory_order_relaxed), count_))) {
                cancelled_ = true;
                return;
            }
            const std::size_t index = next_.fetch_add(1, std::memory_order_relaxed);
            if (index >= count_) return;
            (*task_)(index, worker);
        }
    } catch (...) {
        std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
        cancelled_ = true;
    }
}

bool ThreadPool::run(std::size_t count, const Task& task, const Watch& watch) {
    {
        std::lock_guard lock(mutex_);
        task_ = &task;
        watch_ = &watch;
        count_ = count;
        next_ = 0;
        cancelled_ = false;
        failure_ = nullptr;
        busy_ = static_cast<unsigned>(workers_.size());
        ++job_;
    }
    start_.notify_all();
    work(0);
    std::unique_lock lock(mutex_);
    done_.wait(lock, [this] { return busy_ == 0; });
    if (failure_) std::rethrow_exception(failure_);
    return !cancelled_;
}

}  // namespace votess
