// Threads that wait between jobs. A job is a range of task numbers taken one by one; the calling thread works too.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace votess {

class ThreadPool {
public:
    // task(index, worker): worker is below size(), each worker runs one task at a time.
    using Task = std::function<void(std::size_t index, unsigned worker)>;
    // Called by the calling thread between its tasks with the number of tasks handed out; false cancels the rest.
    using Watch = std::function<bool(std::size_t done)>;

    explicit ThreadPool(unsigned threads);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    [[nodiscard]] unsigned size() const { return static_cast<unsigned>(workers_.size()) + 1; }
    // Runs task for 0 .. count-1 and returns when all are done; false when `watch` cancelled. Rethrows the first
    // exception of a task after the others have stopped.
    bool run(std::size_t count, const Task& task, const Watch& watch = {});

private:
    void serve(unsigned worker);
    void work(unsigned worker);

    std::vector<std::thread> workers_;
    std::mutex mutex_;
    std::condition_variable start_, done_;
    std::uint64_t job_ = 0;
    unsigned busy_ = 0;
    bool quit_ = false;
    const Task* task_ = nullptr;
    const Watch* watch_ = nullptr;
    std::size_t count_ = 0;
    std::atomic<std::size_t> next_{0};
    std::atomic<bool> cancelled_{false};
    std::exception_ptr failure_;
};

}  // namespace votess
