// Threads that wait between jobs. Threads take the task numbers of a job in order; the calling thread works too.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "core/system.hpp"

namespace votess {

// Throws no_threads. In input/, since the message names an option.
[[noreturn]] void throw_no_threads(unsigned requested, unsigned given, const char* name);

class ThreadPool {
public:
    // task(index, worker): worker is below size(). Each worker runs one task at a time.
    using Task = std::function<void(std::size_t index, unsigned worker)>;

    // requested: 0 for one thread per processor, or as many as the system gives. Throws `no_threads` if the system
    // gives fewer than requested. name: of that number in messages, null for the option.
    explicit ThreadPool(unsigned requested, const char* name = nullptr);
    ~ThreadPool();
    ThreadPool(const ThreadPool&) = delete;
    ThreadPool& operator=(const ThreadPool&) = delete;

    [[nodiscard]] unsigned size() const { return size_; }
    [[nodiscard]] unsigned requested() const { return requested_; }
    // False in a child made by fork(), which may only destroy the pool.
    [[nodiscard]] bool has_threads() const { return home_.is_this(); }
    // Runs task for 0 .. count-1. Rethrows the first exception after the other tasks have stopped; one of the calling
    // thread comes first. Tasks may call check_stop(); the calling thread does between tasks and while it waits.
    void run(std::size_t count, const Task& task);
    // Also reports the tasks started as the progress of the current stage.
    void run_stage(std::size_t count, const Task& task);

private:
    struct Crew;

    unsigned requested_, size_ = 1;
    system::HomeProcess home_;
    std::unique_ptr<Crew> crew_;
};

}  // namespace votess
