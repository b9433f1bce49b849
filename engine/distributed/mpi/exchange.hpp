// Messages between ranks of any length, and errors that all ranks throw together.
#pragma once

#include <mpi.h>

#include <functional>
#include <string>
#include <vector>

#include "core/bytes.hpp"

namespace votess::mpi {

// A communicator of its own, so that messages meet no others.
class Ranks {
public:
    explicit Ranks(MPI_Comm comm);
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] int rank() const { return rank_; }

    // Collective, as all that follows. Does the work on each rank; where some fail, all throw the error of the lowest.
    // Work that calls check_others() stops when another rank has failed.
    void together(const std::function<void()>& work) const;
    // Not collective. Throws Stopped, which is no failure of this rank, when another one has failed in together().
    void check_others() const;
    // The text of the lowest rank that has one, else "".
    [[nodiscard]] std::string first_of(std::string text) const;
    // to: by rank. Returns what came, by rank. An empty message is none.
    [[nodiscard]] std::vector<Message> exchange(const std::vector<Message>& to) const;
    [[nodiscard]] std::vector<Message> gather_all(const Message& own) const;
    [[nodiscard]] double minimum(double value) const;
    [[nodiscard]] double maximum(double value) const;
    [[nodiscard]] double sum(double value) const;
    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t maximum(std::uint64_t value) const;
    // What this rank has sent to others.
    [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }
    // Sums the values of the ranks before this one.
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;

private:
    struct Stopped {};

    int share_first(bool mine, int& code, std::string& text) const;
    [[nodiscard]] std::vector<MPI_Request> stop_others() const;
    void clear_stops(std::vector<MPI_Request> own) const;

    MPI_Comm comm_ = MPI_COMM_NULL;
    int size_ = 1, rank_ = 0;
    mutable std::uint64_t bytes_sent_ = 0;
};

}  // namespace votess::mpi
