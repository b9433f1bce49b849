#include "mpi/ranks.hpp"

#include <algorithm>
#include <new>
#include <numeric>
#include <votess/votess.hpp>

#include "progress.hpp"
#include "words.hpp"

namespace clvotess {
namespace {

constexpr std::size_t max_bytes = std::size_t{1} << 30;  // MPI counts by int

std::uint64_t reduced(std::uint64_t value, MPI_Op operation) {
    std::uint64_t result = 0;
    MPI_Allreduce(&value, &result, 1, MPI_UINT64_T, operation, MPI_COMM_WORLD);
    return result;
}

// Calls pass(begin, count) for pieces whose size fits an int.
template <class Pass>
void in_pieces(std::size_t bytes, const Pass& pass) {
    for (std::size_t begin = 0; begin < bytes; begin += max_bytes)
        pass(begin, static_cast<int>(std::min(max_bytes, bytes - begin)));
}

}  // namespace

Ranks::Ranks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
}

void Ranks::together(const std::function<void()>& work) const {
    share_failure(work, true);
}

void Ranks::first_alone(const std::function<void()>& work) const {
    share_failure(
        rank_ == 0 ? work : [] {}, false);
}

void Ranks::share_failure(const std::function<void()>& work, bool named) const {
    int code = exit_code::done;
    std::string text;
    try {
        work();
    } catch (const Failure& failure) {
        code = failure.code();
        text = failure.what();
    } catch (const votess::Error& error) {
        code = exit_code_of(error.code());
        text = in_words_of_options(error.what());
    } catch (const std::bad_alloc&) {
        code = exit_code::runtime_failure;
        text = "out of memory: take more ranks, or fewer on a machine";
    } catch (const std::exception& error) {
        code = exit_code::runtime_failure;
        text = error.what();
    }
    const bool failed = code != exit_code::done;
    const std::uint64_t failures = sum(failed ? 1 : 0);
    if (failures == 0) return;
    int own = failed ? rank_ : size_, first = 0;
    MPI_Allreduce(&own, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (named && failures < static_cast<std::uint64_t>(size_)) text = "rank " + std::to_string(first) + ": " + text;
    int head[2]{code, static_cast<int>(text.size())};
    MPI_Bcast(head, 2, MPI_INT, first, MPI_COMM_WORLD);
    text.resize(static_cast<std::size_t>(head[1]));
    MPI_Bcast(text.data(), head[1], MPI_CHAR, first, MPI_COMM_WORLD);
    throw CommonFailure(head[0], text);
}

std::uint64_t Ranks::sum(std::uint64_t value) const {
    return reduced(value, MPI_SUM);
}

std::uint64_t Ranks::maximum(std::uint64_t value) const {
    return reduced(value, MPI_MAX);
}

std::uint64_t Ranks::sum_before(std::uint64_t value) const {
    std::uint64_t before = 0;
    MPI_Exscan(&value, &before, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);
    return rank_ == 0 ? 0 : before;
}

void Ranks::broadcast(std::vector<char>& bytes) const {
    std::uint64_t size = bytes.size();
    MPI_Bcast(&size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    together([&] { bytes.resize(size); });
    in_pieces(size, [&](std::size_t begin, int count) {
        MPI_Bcast(bytes.data() + begin, count, MPI_CHAR, 0, MPI_COMM_WORLD);
    });
}

std::vector<char> Ranks::deal(std::vector<std::vector<char>>&& of_ranks) const {
    std::vector<std::uint64_t> sizes;
    for (const auto& bytes : of_ranks) sizes.push_back(bytes.size());
    std::uint64_t size = 0;
    MPI_Scatter(sizes.data(), 1, MPI_UINT64_T, &size, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
    std::vector<char> own;
    together([&] {
        if (rank_ != 0) own.resize(size);
    });
    if (rank_ != 0) {
        in_pieces(size, [&](std::size_t begin, int count) {
            MPI_Recv(own.data() + begin, count, MPI_CHAR, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
        });
        return own;
    }
    for (int r = 1; r < size_; ++r) {
        const std::vector<char> bytes = std::move(of_ranks[static_cast<std::size_t>(r)]);
        in_pieces(bytes.size(), [&](std::size_t begin, int count) {
            MPI_Send(bytes.data() + begin, count, MPI_CHAR, r, 0, MPI_COMM_WORLD);
        });
    }
    return std::move(of_ranks[0]);
}

std::vector<char> Ranks::exchange(const std::vector<std::vector<char>>& for_ranks) const {
    const auto ranks = static_cast<std::size_t>(size_);
    std::vector<std::uint64_t> sent(ranks), got(ranks);
    for (std::size_t r = 0; r < ranks; ++r) sent[r] = for_ranks[r].size();
    MPI_Alltoall(sent.data(), 1, MPI_UINT64_T, got.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
    std::vector<char> bytes;
    together([&] { bytes.resize(std::accumulate(got.begin(), got.end(), std::size_t{0})); });
    std::vector<MPI_Request> requests;
    std::size_t place = 0;
    for (std::size_t r = 0; r < ranks; ++r) {
        in_pieces(got[r], [&](std::size_t begin, int count) {
            MPI_Irecv(bytes.data() + place + begin, count, MPI_CHAR, static_cast<int>(r), 0, MPI_COMM_WORLD,
                      &requests.emplace_back());
        });
        place += got[r];
    }
    for (std::size_t r = 0; r < ranks; ++r) {
        in_pieces(sent[r], [&](std::size_t begin, int count) {
            MPI_Isend(for_ranks[r].data() + begin, count, MPI_CHAR, static_cast<int>(r), 0, MPI_COMM_WORLD,
                      &requests.emplace_back());
        });
    }
    MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    return bytes;
}

std::vector<std::uint64_t> Ranks::gather(std::uint64_t value) const {
    std::vector<std::uint64_t> values(static_cast<std::size_t>(size_));
    MPI_Allgather(&value, 1, MPI_UINT64_T, values.data(), 1, MPI_UINT64_T, MPI_COMM_WORLD);
    return values;
}

}  // namespace clvotess
