#include "core/thread_pool.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/progress.hpp"

namespace votess {

// The threads and what they share with the calling one.
struct ThreadPool::Crew {
    explicit Crew(unsigned threads);
    ~Crew() { dismiss(); }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    bool run(std::size_t count, const Task& task, const Watch& watch);
    void dismiss();
    void serve(unsigned worker);
    void work(unsigned worker);

    std::vector<std::thread> workers;
    std::mutex mutex;
    std::condition_variable start, done;
    std::uint64_t job = 0;
    unsigned busy = 0;
    bool quit = false;
    const Task* task = nullptr;
    const Watch* watch = nullptr;
    Watch common_watch;  // of Attended
    std::size_t count = 0;
    std::atomic<std::size_t> next{0};
    std::atomic<bool> cancelled{false};
    std::exception_ptr failure;
};

ThreadPool::Crew::Crew(unsigned threads) {
    try {
        for (unsigned w = 1; w < threads; ++w) workers.emplace_back([this, w] { serve(w); });
    } catch (...) {
        dismiss();
        throw;
    }
}

void ThreadPool::Crew::dismiss() {
    {
        std::lock_guard lock(mutex);
        quit = true;
    }
    start.notify_all();
    for (auto& t : workers) t.join();
    workers.clear();
}

void ThreadPool::Crew::serve(unsigned worker) {
    std::uint64_t seen = 0;
    for (;;) {
        {
            std::unique_lock lock(mutex);
            start.wait(lock, [&] { return quit || job != seen; });
            if (quit) return;
            seen = job;
        }
        work(worker);
        std::lock_guard lock(mutex);
        if (--busy == 0) done.notify_one();
    }
}

void ThreadPool::Crew::work(unsigned worker) {
    try {
        while (!cancelled.load(std::memory_order_relaxed)) {
            if (worker == 0 && *watch && !(*watch)(std::min(next.load(std::memory_order_relaxed), count))) {
                cancelled = true;
                return;
            }
            const std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
            if (index >= count) return;
            (*task)(index, worker);
        }
    } catch (...) {
        std::lock_guard lock(mutex);
        if (!failure) failure = std::current_exception();
        cancelled = true;
    }
}

bool ThreadPool::Crew::run(std::size_t tasks, const Task& each, const Watch& watched) {
    {
        std::lock_guard lock(mutex);
        task = &each;
        watch = &watched;
        count = tasks;
        next = 0;
        cancelled = false;
        failure = nullptr;
        busy = static_cast<unsigned>(workers.size());
        ++job;
    }
    start.notify_all();
    work(0);
    std::unique_lock lock(mutex);
    done.wait(lock, [this] { return busy == 0; });
    if (failure) std::rethrow_exception(failure);
    return !cancelled;
}

ThreadPool::ThreadPool(unsigned threads) : size_(std::max(threads, 1u)), crew_(std::make_unique<Crew>(threads)) {}

// A condition variable on which threads of the parent wait can never be destroyed in its child.
ThreadPool::~ThreadPool() {
    if (!has_threads()) (void)crew_.release();
}

bool ThreadPool::run(std::size_t count, const Task& task, const Watch& watch) {
    if (watch || !crew_->common_watch) return crew_->run(count, task, watch);
    Progress::require(crew_->run(count, task, crew_->common_watch));
    return true;
}

Attended::Attended(ThreadPool& pool, Progress& progress, double fraction) : pool_(pool) {
    if (progress) pool.crew_->common_watch = [&progress, fraction](std::size_t) { return progress.going_on(fraction); };
}

Attended::~Attended() {
    pool_.crew_->common_watch = {};
}

}  // namespace votess
