// The ranks of a run. A failure of one rank becomes a failure of all, reported once.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "failure.hpp"

namespace clvotess {

// Thrown by all ranks together.
class CommonFailure : public Failure {
public:
    using Failure::Failure;
};

// The ranks of MPI_COMM_WORLD. All calls except rank() and size() are collective.
class Ranks {
public:
    Ranks();

    [[nodiscard]] int rank() const noexcept { return rank_; }
    [[nodiscard]] int size() const noexcept { return size_; }

    // Calls work() on each rank. If some fail, all throw the failure of the lowest rank; its number is in the message
    // unless all fail.
    void together(const std::function<void()>& work) const;
    // Calls work() on rank 0. If it fails, all throw the failure.
    void first_alone(const std::function<void()>& work) const;

    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t maximum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;  // over lower ranks
    [[nodiscard]] bool any(bool value) const { return maximum(value ? 1 : 0) > 0; }

    // Sends the bytes of rank 0 to all.
    void broadcast(std::vector<char>& bytes) const;
    // Sends the entry r of rank 0 to rank r; the argument of others is ignored. Returns the received bytes.
    [[nodiscard]] std::vector<char> deal(std::vector<std::vector<char>>&& of_ranks) const;
    // Sends entry r of each rank to rank r. Returns the received bytes, in the order of the senders.
    [[nodiscard]] std::vector<char> exchange(const std::vector<std::vector<char>>& for_ranks) const;
    // Returns the value of each rank.
    [[nodiscard]] std::vector<std::uint64_t> gather(std::uint64_t value) const;

private:
    void share_failure(const std::function<void()>& work, bool named) const;

    int rank_ = 0, size_ = 1;
};

}  // namespace clvotess
