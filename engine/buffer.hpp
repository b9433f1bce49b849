// An array that is not filled when it grows: whoever writes an element first also touches its page first.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

namespace votess {

template <class T>
class Buffer {
    static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept
        : data_(std::move(other.data_)),
          size_(std::exchange(other.size_, 0)),
          capacity_(std::exchange(other.capacity_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        data_ = std::move(other.data_);
        size_ = std::exchange(other.size_, 0);
        capacity_ = std::exchange(other.capacity_, 0);
        return *this;
    }

    [[nodiscard]] T* data() { return data_.get(); }
    [[nodiscard]] const T* data() const { return data_.get(); }
    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] std::size_t capacity() const { return capacity_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    [[nodiscard]] T& operator[](std::size_t i) { return data_.get()[i]; }
    [[nodiscard]] const T& operator[](std::size_t i) const { return data_.get()[i]; }
    [[nodiscard]] T* begin() { return data(); }
    [[nodiscard]] T* end() { return data() + size_; }
    [[nodiscard]] const T* begin() const { return data(); }
    [[nodiscard]] const T* end() const { return data() + size_; }
    operator std::span<T>() { return {data(), size_}; }
    operator std::span<const T>() const { return {data(), size_}; }

    // Memory is kept when the size shrinks. When it must grow, the content is lost, and there is a little room to
    // spare: sizes that depend on the seeds differ from run to run.
    void resize_uninitialized(std::size_t size) {
        if (size > capacity_) {
            data_.reset();
            capacity_ = size_ = 0;
            const std::size_t capacity = size + size / 32;
            if (capacity > std::size_t{PTRDIFF_MAX} / sizeof(T)) throw std::bad_array_new_length();
            data_.reset(static_cast<T*>(::operator new(capacity * sizeof(T), alignment)));
            capacity_ = capacity;
        }
        size_ = size;
    }

private:
    static constexpr std::align_val_t alignment{64};

    struct Free {
        void operator()(T* data) const { ::operator delete(data, alignment); }
    };

    std::unique_ptr<T, Free> data_;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

}  // namespace votess
