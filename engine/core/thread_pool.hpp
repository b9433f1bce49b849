// Threads that wait between jobs. A job is a range of task numbers taken one by one; the calling thread works too.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "core/process.hpp"

namespace votess {

class ThreadPool {
public:
    // task(index, worker): worker is below size(), each worker runs one task at a time.
    using Task = std::function<void(std::size_t index, unsigned worker)>;

    // requested: 0 for one thread for each processor, or as many of them as the system gives. Throws `no_threads` where
    // the system gives fewer than are requested.
    explicit ThreadPool(unsigned requested);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    [[nodiscard]] unsigned size() const { return size_; }
    [[nodiscard]] unsigned requested() const { return requested_; }
    // False in a child made by fork(), which has none of the threads and may only destroy the pool.
    [[nodiscard]] bool has_threads() const { return home_.is_this(); }
    // Runs task for 0 .. count-1 and returns when all are done. Rethrows the first exception of a task after the others
    // have stopped; one of the calling thread comes first. Tasks may call check_stop(). The calling thread does so
    // between its tasks, and while it waits for the others.
    void run(std::size_t count, const Task& task);
    // The same, and reports the tasks handed out as the progress of the stage at hand.
    void run_stage(std::size_t count, const Task& task);

private:
    struct Crew;

    unsigned requested_, size_ = 1;
    HomeProcess home_;
    std::unique_ptr<Crew> crew_;
};

}  // namespace votess
