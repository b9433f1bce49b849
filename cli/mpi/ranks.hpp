// The ranks that run the program together: what one has wrong all say, once.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "failure.hpp"

namespace clvotess {

// What all ranks throw together.
class CommonFailure : public Failure {
public:
    using Failure::Failure;
};

// Those of MPI_COMM_WORLD. All calls but rank() and size() are collective.
class Ranks {
public:
    Ranks();

    [[nodiscard]] int rank() const noexcept { return rank_; }
    [[nodiscard]] int size() const noexcept { return size_; }

    // Does the work on each rank. Where some fail, all throw the failure of the lowest, which is named unless all fail.
    void together(const std::function<void()>& work) const;
    // The same of what rank 0 alone does, which is not named.
    void first_alone(const std::function<void()>& work) const;

    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t maximum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;  // of lower ranks
    [[nodiscard]] bool any(bool value) const { return maximum(value ? 1 : 0) > 0; }

    // What rank 0 has goes to all.
    void broadcast(std::vector<char>& bytes) const;
    // What rank 0 has for each goes there; others give nothing. Returns what came.
    [[nodiscard]] std::vector<char> deal(std::vector<std::vector<char>>&& of_ranks) const;
    // What each rank has for each goes there. Returns what came, in the order of the ranks.
    [[nodiscard]] std::vector<char> exchange(const std::vector<std::vector<char>>& for_ranks) const;
    // The value of each rank.
    [[nodiscard]] std::vector<std::uint64_t> gather(std::uint64_t value) const;

private:
    void share_failure(const std::function<void()>& work, bool named) const;

    int rank_ = 0, size_ = 1;
};

}  // namespace clvotess
