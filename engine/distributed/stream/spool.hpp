// Arrays in temporary files.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/packed.hpp"
#include "core/system.hpp"

namespace votess::stream {

// The bytes of several files on the disk. They grow on one thread.
class DiskUse {
public:
    void add(std::uint64_t bytes) { peak_ = std::max(peak_, now_ += bytes); }
    void subtract(std::uint64_t bytes) { now_ -= bytes; }
    [[nodiscard]] std::uint64_t now() const { return now_; }
    [[nodiscard]] std::uint64_t peak() const { return peak_; }

private:
    std::atomic<std::uint64_t> now_ = 0;
    std::uint64_t peak_ = 0;
};

// A file that only grows. It has no name, so it ends with the process. Throws Error(storage).
class TemporaryFile {
public:
    // folder: see temporary_folder(). use: outlives the file.
    TemporaryFile(const std::string& folder, DiskUse& use);
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile() { use_.subtract(on_disk_); }

    // Returns the position of the bytes.
    std::uint64_t append(std::span<const std::byte> bytes);
    // These may be called from any thread. release() returns the disk space of bytes that are not needed any more, as
    // far as the system can.
    void read(std::uint64_t at, std::span<std::byte> to) const;
    void release(std::uint64_t begin, std::uint64_t end);

private:
    system::File file_;
    DiskUse& use_;
    std::uint64_t size_ = 0;
    std::atomic<std::uint64_t> on_disk_ = 0;
};

// Returns the folder, or system::temporary_folder() for "".
[[nodiscard]] std::string temporary_folder(const std::string& folder);
// Throws invalid_argument when the folder cannot be used.
[[nodiscard]] std::uint64_t free_bytes(const std::string& folder);

// An array in a file, which may hold several that grow side by side. Values are packed, see core/packed.hpp. They are
// read front to back.
class Spool {
public:
    explicit Spool(TemporaryFile& file) : file_(&file) {}

    // From now on, what has been read leaves the disk.
    void release_as_read() { releases_ = true; }

    // Appends a piece or more; bytes are one piece.
    template <class T>
    void append(std::span<const T> values) {
        constexpr std::size_t most = sizeof(T) > 1 ? max_piece : std::numeric_limits<std::size_t>::max();
        for (std::size_t begin = 0; begin < values.size(); begin += std::min(most, values.size() - begin)) {
            const auto piece = values.subspan(begin, std::min(most, values.size() - begin));
            std::vector<std::byte> packed;
            const PackedHead head = pack(piece, packed);
            append_bytes(std::as_bytes(std::span(&head, 1)));
            append_bytes(head.is_plain() ? std::as_bytes(piece) : std::span<const std::byte>(packed));
            size_ += piece.size();
        }
    }
    // Reads the next values.
    template <class T>
    void read(std::span<T> values) {
        static_assert(std::is_trivially_copyable_v<T>);
        read_values(std::as_writable_bytes(values));
    }
    // The next piece.
    template <class T>
    [[nodiscard]] std::vector<T> read_piece() {
        if (unpacker_.values() == 0) next_piece();
        std::vector<T> values(static_cast<std::size_t>(unpacker_.values()));
        read(std::span(values));
        return values;
    }
    template <class T>
    [[nodiscard]] std::vector<T> read_rest() {
        std::vector<T> values(static_cast<std::size_t>(remaining()));
        read(std::span(values));
        return values;
    }
    [[nodiscard]] std::uint64_t size() const { return size_; }  // values
    [[nodiscard]] std::uint64_t remaining() const { return size_ - read_; }
    void rewind() {
        read_ = 0;
        at_ = {};
        unpacker_ = {};
    }

private:
    static constexpr std::size_t max_piece = 65536;  // values

    struct Extent {
        std::uint64_t at, size;
    };
    struct Place {
        std::size_t extent = 0;    // of the next byte
        std::uint64_t within = 0;  // its position in that extent
    };
    void append_bytes(std::span<const std::byte> bytes);
    void read_values(std::span<std::byte> to);
    void next_piece();
    void release();
    // Reads the bytes at a place. Returns the place behind them.
    Place read_bytes(Place at, std::span<std::byte> to) const;
    [[nodiscard]] Place after(Place at, std::uint64_t bytes) const;

    TemporaryFile* file_;
    std::vector<Extent> extents_;
    std::uint64_t size_ = 0, read_ = 0;
    Place at_, released_;  // released_: the first byte that has not left the disk
    bool releases_ = false;
    Unpacker unpacker_;  // of the current piece
};

// Reads a spool value by value.
template <class T>
class Cursor {
public:
    explicit Cursor(Spool spool) : spool_(std::move(spool)) {}
    // Returns the next value, or null at the end.
    [[nodiscard]] const T* peek() {
        if (at_ == values_.size()) {
            values_.resize(std::min<std::size_t>(max_values, static_cast<std::size_t>(spool_.remaining())));
            spool_.read(std::span(values_));
            at_ = 0;
        }
        return values_.empty() ? nullptr : &values_[at_];
    }
    void pop() { ++at_; }

private:
    static constexpr std::size_t max_values = 1024;
    Spool spool_;
    std::vector<T> values_;
    std::size_t at_ = 0;
};

}  // namespace votess::stream
