#include "core/thread_pool.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "core/processors.hpp"
#include "core/progress.hpp"

namespace votess {

struct ThreadPool::Crew {
    // Makes fewer threads if the system gives no more.
    explicit Crew(unsigned threads);
    ~Crew() { dismiss(); }
    Crew(const Crew&) = delete;
    Crew& operator=(const Crew&) = delete;

    void run(std::size_t count, const Task& task, bool is_stage);
    void dismiss();
    void serve(unsigned worker);
    void work(unsigned worker);
    void fail(unsigned worker);
    void wait();

    std::vector<std::thread> workers;
    std::mutex mutex;
    std::condition_variable start, done;
    std::uint64_t job = 0;
    unsigned busy = 0;
    bool quit = false;
    const Task* task = nullptr;
    bool is_stage = false;
    Stoppable* stoppable = nullptr;  // of the calling thread
    std::size_t count = 0;
    std::atomic<std::size_t> next{0};
    std::atomic<bool> cancelled{false};
    std::exception_ptr failure;
};

ThreadPool::Crew::Crew(unsigned threads) {
    workers.reserve(threads - 1);
    try {
        for (unsigned w = 1; w < threads; ++w) workers.emplace_back([this, w] { serve(w); });
    } catch (const std::system_error&) {
        return;
    } catch (const std::bad_alloc&) {
        return;
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
        {
            const Stoppable::Scope scope(stoppable, false);
            work(worker);
        }
        std::lock_guard lock(mutex);
        if (--busy == 0) done.notify_one();
    }
}

void ThreadPool::Crew::work(unsigned worker) {
    try {
        while (!cancelled.load(std::memory_order_relaxed)) {
            if (worker == 0 && is_stage)
                report_stage(std::min(next.load(std::memory_order_relaxed), count), count);
            else
                check_stop();
            const std::size_t index = next.fetch_add(1, std::memory_order_relaxed);
            if (index >= count) return;
            (*task)(index, worker);
        }
    } catch (...) {
        fail(worker);
    }
}

// An exception of the user's callback precedes those that it causes in other threads.
void ThreadPool::Crew::fail(unsigned worker) {
    std::lock_guard lock(mutex);
    if (!failure || worker == 0) failure = std::current_exception();
    cancelled = true;
}

void ThreadPool::Crew::wait() {
    constexpr std::chrono::milliseconds poll_interval{10};
    const auto all_done = [this] { return busy == 0; };
    std::unique_lock lock(mutex);
    while (stoppable != nullptr && !cancelled && !done.wait_for(lock, poll_interval, all_done)) {
        lock.unlock();
        try {
            check_stop();
        } catch (...) {
            fail(0);
        }
        lock.lock();
    }
    done.wait(lock, all_done);
}

void ThreadPool::Crew::run(std::size_t tasks, const Task& each, bool stage) {
    const bool wakes = tasks > 1;  // else that would take longer than most tasks
    {
        std::lock_guard lock(mutex);
        task = &each;
        is_stage = stage;
        stoppable = Stoppable::current();
        count = tasks;
        next = 0;
        cancelled = false;
        failure = nullptr;
        busy = wakes ? static_cast<unsigned>(workers.size()) : 0;
        if (wakes) ++job;
    }
    if (wakes) start.notify_all();
    work(0);
    wait();
    if (failure) std::rethrow_exception(failure);
}

ThreadPool::ThreadPool(unsigned requested, const char* name) : requested_(requested) {
    crew_ = std::make_unique<Crew>(requested == 0 ? system::processors() : requested);
    size_ = static_cast<unsigned>(crew_->workers.size()) + 1;
    if (size_ >= requested) return;
    crew_.reset();  // frees memory that the message needs
    throw_no_threads(requested, size_, name);
}

// A child must not destroy a condition variable on which the parent's threads wait.
ThreadPool::~ThreadPool() {
    if (!has_threads()) (void)crew_.release();
}

void ThreadPool::run(std::size_t count, const Task& task) {
    crew_->run(count, task, false);
}

void ThreadPool::run_stage(std::size_t count, const Task& task) {
    crew_->run(count, task, true);
}

}  // namespace votess
