// Threads that wait between jobs. A job is a range of task numbers taken one by one; the calling thread works too.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "core/home_process.hpp"

namespace votess {

class Progress;

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

    [[nodiscard]] unsigned size() const { return size_; }
    // False in a child made by fork(), which has none of the threads and may only destroy the pool.
    [[nodiscard]] bool has_threads() const { return home_.is_this(); }
    // Runs task for 0 .. count-1 and returns when all are done; false when `watch` cancelled. Rethrows the first
    // exception of a task after the others have stopped.
    bool run(std::size_t count, const Task& task, const Watch& watch = {});

private:
    friend class Attended;
    struct Crew;

    unsigned size_;
    HomeProcess home_;
    std::unique_ptr<Crew> crew_;
};

// Lets the user cancel jobs that have no watch of their own, while it lives: run() then throws `cancelled`. `progress`
// stays at `fraction`. It and the pool live longer.
class Attended {
public:
    Attended(ThreadPool& pool, Progress& progress, double fraction);
    ~Attended();
    Attended(const Attended&) = delete;
    Attended& operator=(const Attended&) = delete;

private:
    ThreadPool& pool_;
};

}  // namespace votess
