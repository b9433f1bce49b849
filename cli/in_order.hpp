// Work on threads whose results are used in order: rows of text that are parsed or written.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/processors.hpp"

namespace clvotess {

// Calls make(0) .. make(count - 1) on threads, and take(result) in that order on the calling thread, until take returns
// false. Few results wait at a time. Throws the first exception in order. threads: 0 for one per processor; fewer if
// the system gives fewer.
template <class Make, class Take>
void in_order(std::size_t count, unsigned threads, const Make& make, const Take& take) {
    if (threads == 0) threads = votess::system::processors();
    const std::size_t wanted = std::min<std::size_t>(threads, count);
    struct Slot {
        std::optional<std::invoke_result_t<const Make&, std::size_t>> made;
        std::exception_ptr failure;
    };
    std::vector<Slot> slots(2 * wanted);
    std::mutex mutex;  // of the slots and these numbers
    std::condition_variable work, results;
    std::size_t next = 0, taken = 0;
    bool stopped = false;
    const auto run = [&] {
        for (;;) {
            std::size_t index = 0;
            {
                std::unique_lock lock(mutex);
                work.wait(lock, [&] { return stopped || next == count || next < taken + slots.size(); });
                if (stopped || next == count) return;
                index = next++;
            }
            Slot slot;
            try {
                slot.made.emplace(make(index));
            } catch (...) {
                slot.failure = std::current_exception();
            }
            const std::lock_guard lock(mutex);
            slots[index % slots.size()] = std::move(slot);
            results.notify_one();
        }
    };
    struct Workers {
        std::vector<std::thread> threads;
        const std::function<void()> stop;
        ~Workers() {
            stop();
            for (std::thread& thread : threads) thread.join();
        }
    } workers{{}, [&] {
                  const std::lock_guard lock(mutex);
                  stopped = true;
                  work.notify_all();
              }};
    try {
        while (wanted > 1 && workers.threads.size() < wanted) workers.threads.emplace_back(run);
    } catch (const std::system_error&) {
    }
    for (std::size_t index = 0; index < count; ++index) {
        if (workers.threads.empty()) {
            if (!take(make(index))) return;
            continue;
        }
        Slot slot;
        {
            std::unique_lock lock(mutex);
            Slot& place = slots[index % slots.size()];
            results.wait(lock, [&] { return place.made || place.failure; });
            slot = std::exchange(place, {});
            taken = index + 1;
            work.notify_all();
        }
        if (slot.failure) std::rethrow_exception(slot.failure);
        if (!take(std::move(*slot.made))) return;
    }
}

}  // namespace clvotess
