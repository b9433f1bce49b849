#include "distributed/mpi/exchange.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "core/box.hpp"

namespace votess::mpi {
namespace {

constexpr std::size_t max_message_bytes = std::size_t{1} << 30;  // MPI counts by int
constexpr int data_tag = 0, stop_tag = 1;

void check(int code, const char* what) {
    if (code == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(code, text, &length);
    throw Error(ErrorCode::internal, std::string(what) + ": " + std::string(text, static_cast<std::size_t>(length)));
}

template <class T>
T reduced(MPI_Comm comm, T value, MPI_Datatype type, MPI_Op operation) {
    T result{};
    check(MPI_Allreduce(&value, &result, 1, type, operation, comm), "MPI_Allreduce");
    return result;
}

}  // namespace

Ranks::Ranks(MPI_Comm comm) {
    int begun = 0;
    MPI_Initialized(&begun);
    if (begun == 0) throw Error(ErrorCode::invalid_use, "MPI is not initialized: call MPI_Init first");
    check(MPI_Comm_dup(comm, &comm_), "MPI_Comm_dup");
    MPI_Comm_size(comm_, &size_);
    MPI_Comm_rank(comm_, &rank_);
}

Ranks::~Ranks() {
    if (comm_ != MPI_COMM_NULL) MPI_Comm_free(&comm_);
}

void Ranks::together(const std::function<void()>& work) const {
    int code = 0;
    std::string text;
    try {
        work();
    } catch (const Stopped&) {
    } catch (const Error& error) {
        code = static_cast<int>(error.code());
        text = error.what();
    } catch (const std::bad_alloc&) {
        code = static_cast<int>(ErrorCode::out_of_memory);
        text = "out of memory: use more ranks, or fewer on a machine";
    } catch (const std::exception& error) {
        code = static_cast<int>(ErrorCode::internal);
        text = error.what();
    } catch (...) {
        code = static_cast<int>(ErrorCode::internal);
        text = "the progress callback threw something else than a std::exception";
    }
    std::vector<MPI_Request> stops;
    if (code != 0) stops = stop_others();
    const int first = share_first_error(code, text);
    if (first == size_) return;
    clear_stops(std::move(stops));
    throw Error(static_cast<ErrorCode>(code), "rank " + std::to_string(first) + ": " + text);
}

void Ranks::check_others() const {
    int failed = 0;
    check(MPI_Iprobe(MPI_ANY_SOURCE, stop_tag, comm_, &failed, MPI_STATUS_IGNORE), "MPI_Iprobe");
    if (failed != 0) throw Stopped{};
}

// Sends an empty message to all ranks, itself included, so that all get equally many.
std::vector<MPI_Request> Ranks::stop_others() const {
    std::vector<MPI_Request> sent(static_cast<std::size_t>(size_));
    for (int r = 0; r < size_; ++r)
        check(MPI_Isend(nullptr, 0, MPI_BYTE, r, stop_tag, comm_, &sent[static_cast<std::size_t>(r)]), "MPI_Isend");
    return sent;
}

// Receives the messages of all ranks that have failed.
void Ranks::clear_stops(std::vector<MPI_Request> own) const {
    const int failed = reduced(comm_, own.empty() ? 0 : 1, MPI_INT, MPI_SUM);
    for (int k = 0; k < failed; ++k)
        check(MPI_Recv(nullptr, 0, MPI_BYTE, MPI_ANY_SOURCE, stop_tag, comm_, MPI_STATUS_IGNORE), "MPI_Recv");
    check(MPI_Waitall(static_cast<int>(own.size()), own.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
}

// Sends the error of the lowest rank that has one to all. Returns that rank, or the number of ranks.
int Ranks::share_first_error(int& code, std::string& text) const {
    const int first = reduced(comm_, code != 0 ? rank_ : size_, MPI_INT, MPI_MIN);
    if (first == size_) return first;
    int head[2]{code, static_cast<int>(text.size())};
    check(MPI_Bcast(head, 2, MPI_INT, first, comm_), "MPI_Bcast");
    code = head[0];
    text.resize(static_cast<std::size_t>(head[1]));
    check(MPI_Bcast(text.data(), head[1], MPI_CHAR, first, comm_), "MPI_Bcast");
    return first;
}

void Ranks::agree(std::string_view function, std::span<const CommonArgument> arguments) const {
    Hash all;
    Writer own;
    own.put(Hash().mix_bytes(std::as_bytes(std::span(function))).value());
    for (const CommonArgument& argument : arguments) own.put(argument.hash);
    const Message message = own.take();
    const std::uint64_t hash = all.mix_bytes(message).value();
    const std::uint64_t largest = maximum(hash), least = ~maximum(~hash);
    if (least == largest) return;
    const Message first = gather_all(message).front();
    together([&] {
        const auto refuse = [&](const std::string& what) {
            throw Error(ErrorCode::invalid_argument, what + " differs from that of rank 0: give all ranks the same");
        };
        const auto differs = [&](std::size_t k) {
            return std::memcmp(&message[k * sizeof hash], &first[k * sizeof hash], sizeof hash) != 0;
        };
        if (differs(0)) refuse("the call of " + std::string(function) + "()");
        for (std::size_t k = 0; k < arguments.size(); ++k)
            if (differs(k + 1)) refuse(std::string(arguments[k].name));
    });
}

std::vector<Message> Ranks::exchange(const std::vector<Message>& to) const {
    const auto count = static_cast<std::size_t>(size_);
    std::vector<std::uint64_t> sent(count), coming(count);
    for (std::size_t r = 0; r < count; ++r) {
        sent[r] = to[r].size();
        if (r != static_cast<std::size_t>(rank_)) bytes_sent_ += sent[r];
    }
    check(MPI_Alltoall(sent.data(), 1, MPI_UINT64_T, coming.data(), 1, MPI_UINT64_T, comm_), "MPI_Alltoall");
    std::vector<Message> from(count);
    // All ranks must have the memory before any sends.
    together([&] {
        for (std::size_t r = 0; r < count; ++r) from[r].resize(coming[r]);
    });
    from[static_cast<std::size_t>(rank_)] = to[static_cast<std::size_t>(rank_)];
    std::vector<MPI_Request> requests;
    const auto pieces = [&](std::size_t bytes, const auto& post) {
        for (std::size_t begin = 0; begin < bytes; begin += max_message_bytes)
            check(post(begin, static_cast<int>(std::min(max_message_bytes, bytes - begin)), &requests.emplace_back()),
                  "a message between ranks");
    };
    for (std::size_t step = 1; step < count; ++step) {
        const std::size_t r = (static_cast<std::size_t>(rank_) + step) % count;
        pieces(from[r].size(), [&](std::size_t begin, int bytes, MPI_Request* request) {
            return MPI_Irecv(from[r].data() + begin, bytes, MPI_BYTE, static_cast<int>(r), data_tag, comm_, request);
        });
    }
    for (std::size_t step = 1; step < count; ++step) {
        const std::size_t r = (static_cast<std::size_t>(rank_) + step) % count;
        pieces(to[r].size(), [&](std::size_t begin, int bytes, MPI_Request* request) {
            return MPI_Isend(to[r].data() + begin, bytes, MPI_BYTE, static_cast<int>(r), data_tag, comm_, request);
        });
    }
    check(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE), "MPI_Waitall");
    return from;
}

std::vector<Message> Ranks::gather_all(const Message& own) const {
    return exchange(std::vector<Message>(static_cast<std::size_t>(size_), own));
}

Box Ranks::bounds_of(std::span<const double> points) const {
    Box bounds = votess::bounds_of(points);
    for (std::size_t k = 0; k < 3; ++k) {
        bounds.lower[k] = minimum(bounds.lower[k]);
        bounds.upper[k] = maximum(bounds.upper[k]);
    }
    return bounds;
}

double Ranks::minimum(double value) const {
    return reduced(comm_, value, MPI_DOUBLE, MPI_MIN);
}
double Ranks::maximum(double value) const {
    return reduced(comm_, value, MPI_DOUBLE, MPI_MAX);
}
double Ranks::sum(double value) const {
    return reduced(comm_, value, MPI_DOUBLE, MPI_SUM);
}
std::uint64_t Ranks::sum(std::uint64_t value) const {
    return reduced(comm_, value, MPI_UINT64_T, MPI_SUM);
}
std::uint64_t Ranks::maximum(std::uint64_t value) const {
    return reduced(comm_, value, MPI_UINT64_T, MPI_MAX);
}

std::uint64_t Ranks::sum_before(std::uint64_t value) const {
    std::uint64_t before = 0;
    check(MPI_Exscan(&value, &before, 1, MPI_UINT64_T, MPI_SUM, comm_), "MPI_Exscan");
    return rank_ == 0 ? 0 : before;
}

}  // namespace votess::mpi
