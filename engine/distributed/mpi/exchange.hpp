// Messages of any length between ranks, and errors that all ranks throw together.
#pragma once

#include <mpi.h>

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bytes.hpp"
#include "votess/votess.hpp"

namespace votess::mpi {

// A hash (FNV-1a) of values without padding.
class Hash {
public:
    template <class... T>
    Hash& mix(const T&... values) {
        (mix_bytes(std::as_bytes(std::span(&values, 1))), ...);
        return *this;
    }
    Hash& mix_bytes(std::span<const std::byte> bytes) {
        for (const std::byte byte : bytes) value_ = (value_ ^ static_cast<std::uint64_t>(byte)) * 1099511628211u;
        return *this;
    }
    [[nodiscard]] std::uint64_t value() const { return value_; }

private:
    std::uint64_t value_ = 14695981039346656037u;
};

// An argument that all ranks must give equal values, by their hash.
struct CommonArgument {
    std::string_view name;
    std::uint64_t hash;
};

// Duplicates the communicator, so that messages meet no others.
class Ranks {
public:
    explicit Ranks(MPI_Comm comm);
    ~Ranks();
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    [[nodiscard]] int size() const { return size_; }
    [[nodiscard]] int rank() const { return rank_; }

    // Does the work on each rank. If it throws on some, all throw the error of the lowest. Work that calls
    // check_others() stops when another rank has failed. Collective, like all functions below except check_others().
    void together(const std::function<void()>& work) const;
    // Throws Stopped, which together() ignores, when another rank has failed in together(). Not collective.
    void check_others() const;
    // Throws, on all ranks, unless all call the same function with equal arguments. Each function of several ranks
    // calls this before anything else.
    void agree(std::string_view function, std::span<const CommonArgument> arguments) const;
    // to: by rank. Returns the messages to this rank, by rank.
    [[nodiscard]] std::vector<Message> exchange(const std::vector<Message>& to) const;
    [[nodiscard]] std::vector<Message> gather_all(const Message& own) const;
    // Returns the bounds of the points of all ranks. points: (N, 3).
    [[nodiscard]] Box bounds_of(std::span<const double> points) const;
    [[nodiscard]] double minimum(double value) const;
    [[nodiscard]] double maximum(double value) const;
    [[nodiscard]] double sum(double value) const;
    [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
    [[nodiscard]] std::uint64_t maximum(std::uint64_t value) const;
    // Returns the bytes that this rank has sent to others.
    [[nodiscard]] std::uint64_t bytes_sent() const { return bytes_sent_; }
    // Returns the sum over the ranks before this one.
    [[nodiscard]] std::uint64_t sum_before(std::uint64_t value) const;

private:
    struct Stopped {};

    int share_first_error(int& code, std::string& text) const;
    [[nodiscard]] std::vector<MPI_Request> stop_others() const;
    void clear_stops(std::vector<MPI_Request> own) const;

    MPI_Comm comm_ = MPI_COMM_NULL;
    int size_ = 1, rank_ = 0;
    mutable std::uint64_t bytes_sent_ = 0;
};

}  // namespace votess::mpi
