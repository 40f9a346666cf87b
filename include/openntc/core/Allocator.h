// SPDX-License-Identifier: MIT
// Stability: stable
// The optional allocator that every runtime object takes, and an owning array that reports exhaustion as a
// Status.
#pragma once

#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Source of memory for the runtime. Must outlive every object made with it. Calls may come from any thread
/// that uses an OpenNTC object; the implementation does its own locking if it is shared.
class Allocator {
public:
    virtual ~Allocator() = default;

    /// Returns at least `bytes` (> 0) bytes aligned for std::max_align_t, or null when there is none.
    virtual void* Allocate(std::size_t bytes) noexcept = 0;

    /// Takes back a block; `bytes` is the size it was asked for with.
    virtual void Deallocate(void* block, std::size_t bytes) noexcept = 0;
};

/// The allocator used where none is given: std::malloc.
inline Allocator& GetDefaultAllocator() noexcept {
    class MallocAllocator final : public Allocator {
        void* Allocate(std::size_t bytes) noexcept override { return std::malloc(bytes); }
        void Deallocate(void* block, std::size_t) noexcept override { std::free(block); }
    };
    static MallocAllocator allocator;
    return allocator;
}

/// A move-only, growable array whose growth can fail without exceptions. Elements must be nothrow-movable.
template <typename T>
class Array {
    static_assert(std::is_nothrow_move_constructible_v<T> && std::is_nothrow_destructible_v<T>);
    static_assert(alignof(T) <= alignof(std::max_align_t));

public:
    Array() noexcept : Array(GetDefaultAllocator()) {}
    explicit Array(Allocator& allocator) noexcept : allocator_(&allocator) {}
    Array(Array&& other) noexcept
        : allocator_(other.allocator_), data_(std::exchange(other.data_, nullptr)),
          size_(std::exchange(other.size_, 0)), capacity_(std::exchange(other.capacity_, 0)) {}
    Array& operator=(Array&& other) noexcept {
        if (this != &other) {
            Release();
            allocator_ = other.allocator_;
            data_ = std::exchange(other.data_, nullptr);
            size_ = std::exchange(other.size_, 0);
            capacity_ = std::exchange(other.capacity_, 0);
        }
        return *this;
    }
    Array(const Array&) = delete;
    Array& operator=(const Array&) = delete;
    ~Array() { Release(); }

    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    T* data() noexcept { return data_; }
    const T* data() const noexcept { return data_; }
    T* begin() noexcept { return data_; }
    T* end() noexcept { return data_ + size_; }
    const T* begin() const noexcept { return data_; }
    const T* end() const noexcept { return data_ + size_; }
    T& operator[](std::size_t i) noexcept { return data_[i]; }
    const T& operator[](std::size_t i) const noexcept { return data_[i]; }
    T& back() noexcept { return data_[size_ - 1]; }
    std::span<T> AsSpan() noexcept { return {data_, size_}; }
    std::span<const T> AsSpan() const noexcept { return {data_, size_}; }
    Allocator& GetAllocator() const noexcept { return *allocator_; }

    void clear() noexcept {
        if constexpr (!std::is_trivially_destructible_v<T>) {
            for (std::size_t i = size_; i > 0; --i)
                data_[i - 1].~T();
        }
        size_ = 0;
    }

    Expected<void> Reserve(std::size_t capacity) noexcept {
        if (capacity <= capacity_)
            return {};
        if (capacity > std::numeric_limits<std::size_t>::max() / sizeof(T))
            return Fail(Status::OutOfMemory, "allocation: %zu elements of %zu bytes: address space", capacity,
                        sizeof(T));
        void* block = allocator_->Allocate(capacity * sizeof(T));
        if (block == nullptr)
            return Fail(Status::OutOfMemory, "allocation: %zu bytes: refused by the allocator",
                        capacity * sizeof(T));
        T* moved = static_cast<T*>(block);
        if constexpr (std::is_trivially_copyable_v<T>) {
            if (size_ > 0)
                std::memcpy(block, data_, size_ * sizeof(T));
        } else {
            for (std::size_t i = 0; i < size_; ++i) {
                ::new (static_cast<void*>(moved + i)) T(std::move(data_[i]));
                data_[i].~T();
            }
        }
        if (data_ != nullptr)
            allocator_->Deallocate(data_, capacity_ * sizeof(T));
        data_ = moved;
        capacity_ = capacity;
        return {};
    }

    /// New elements are value-initialised (zero for numbers).
    Expected<void> Resize(std::size_t size) noexcept {
        OPENNTC_CHECK(Reserve(size));
        while (size_ > size)
            data_[--size_].~T();
        if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::byte>) {
            if (size > size_)
                std::memset(static_cast<void*>(data_ + size_), 0, (size - size_) * sizeof(T));
            size_ = size;
        } else {
            for (; size_ < size; ++size_)
                ::new (static_cast<void*>(data_ + size_)) T();
        }
        return {};
    }

    Expected<void> PushBack(T value) noexcept {
        if (size_ == capacity_)
            OPENNTC_CHECK(Reserve(capacity_ < 4 ? 8 : capacity_ * 2));
        ::new (static_cast<void*>(data_ + size_)) T(std::move(value));
        ++size_;
        return {};
    }

    /// There must be an element.
    void pop_back() noexcept { data_[--size_].~T(); }

    /// Replaces the contents with a copy of `values`.
    Expected<void> Assign(std::span<const T> values) noexcept requires std::is_trivially_copyable_v<T> {
        clear();
        OPENNTC_CHECK(Reserve(values.size()));
        if (!values.empty())
            std::memcpy(static_cast<void*>(data_), values.data(), values.size_bytes());
        size_ = values.size();
        return {};
    }

    /// Adds a copy of `values`, which must not lie in this array. Room grows in steps that keep the cost
    /// linear.
    Expected<void> Append(std::span<const T> values) noexcept requires std::is_trivially_copyable_v<T> {
        if (values.empty())
            return {};
        if (values.size() > capacity_ - size_) {
            if (values.size() > std::numeric_limits<std::size_t>::max() / 2 - size_)
                return Fail(Status::OutOfMemory, "allocation: %zu more elements: address space",
                            values.size());
            const std::size_t needed = size_ + values.size();
            OPENNTC_CHECK(Reserve(needed > capacity_ * 2 ? needed : capacity_ * 2));
        }
        std::memcpy(static_cast<void*>(data_ + size_), values.data(), values.size_bytes());
        size_ += values.size();
        return {};
    }

private:
    void Release() noexcept {
        clear();
        if (data_ != nullptr)
            allocator_->Deallocate(data_, capacity_ * sizeof(T));
        data_ = nullptr;
        capacity_ = 0;
    }

    Allocator* allocator_;
    T* data_ = nullptr;
    std::size_t size_ = 0;
    std::size_t capacity_ = 0;
};

/// An owned UTF-8 string without NUL terminator.
class Text {
public:
    Text() noexcept = default;
    explicit Text(Allocator& allocator) noexcept : characters_(allocator) {}

    Expected<void> Assign(std::string_view text) noexcept {
        return characters_.Assign(std::span<const char>(text.data(), text.size()));
    }
    std::string_view View() const noexcept { return {characters_.data(), characters_.size()}; }

private:
    Array<char> characters_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
