// SPDX-License-Identifier: MIT
// Stability: experimental
// Shared ownership whose making can fail without exceptions: what std::shared_ptr is to code that may throw.
#pragma once

#include "openntc/core/Allocator.h"

#include <atomic>
#include <cstdint>
#include <new>
#include <type_traits>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

template <typename T>
class Shared;

template <typename T, typename... Arguments>
Expected<Shared<T>> MakeShared(Allocator& allocator, Arguments&&... arguments);

namespace detail {

struct SharedBlock {
    std::atomic<std::uint32_t> owners{1};
    void (*destroy)(SharedBlock* block) noexcept = nullptr;
};

} // namespace detail

/// One of the owners of an object, or empty. Copies may be made and dropped by several threads at once; the
/// last one destroys the object. Each copy by itself belongs to one thread at a time.
template <typename T>
class Shared {
public:
    Shared() noexcept = default;
    Shared(const Shared& other) noexcept : object_(other.object_), block_(other.block_) { Add(); }
    Shared(Shared&& other) noexcept
        : object_(std::exchange(other.object_, nullptr)), block_(std::exchange(other.block_, nullptr)) {}
    template <typename Other>
    Shared(const Shared<Other>& other) noexcept requires std::is_convertible_v<Other*, T*>
        : object_(other.object_), block_(other.block_) {
        Add();
    }
    Shared& operator=(Shared other) noexcept {
        std::swap(object_, other.object_);
        std::swap(block_, other.block_);
        return *this;
    }
    ~Shared() {
        if (block_ != nullptr && block_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1)
            block_->destroy(block_);
    }

    /// Refers to an object that somebody else owns and keeps until every copy of this is gone.
    static Shared Borrow(T& object) noexcept {
        Shared borrowed;
        borrowed.object_ = &object;
        return borrowed;
    }

    T* Get() const noexcept { return object_; }
    T* operator->() const noexcept { return object_; }
    T& operator*() const noexcept { return *object_; }
    explicit operator bool() const noexcept { return object_ != nullptr; }

private:
    template <typename Other>
    friend class Shared;
    template <typename Made, typename... Arguments>
    friend Expected<Shared<Made>> MakeShared(Allocator& allocator, Arguments&&... arguments);

    void Add() const noexcept {
        if (block_ != nullptr)
            block_->owners.fetch_add(1, std::memory_order_relaxed);
    }

    T* object_ = nullptr;
    detail::SharedBlock* block_ = nullptr;
};

/// Makes an object and its first owner. The allocator must outlive the object. Errors: OutOfMemory.
template <typename T, typename... Arguments>
Expected<Shared<T>> MakeShared(Allocator& allocator, Arguments&&... arguments) {
    struct Block : detail::SharedBlock {
        Block(Allocator& from, Arguments&&... given)
            : allocator(&from), object(std::forward<Arguments>(given)...) {}
        Allocator* allocator;
        T object;
    };
    static_assert(alignof(Block) <= alignof(std::max_align_t));
    void* memory = allocator.Allocate(sizeof(Block));
    if (memory == nullptr)
        return Fail(Status::OutOfMemory, "allocation: %zu bytes: refused by the allocator", sizeof(Block));
    Block* block = ::new (memory) Block(allocator, std::forward<Arguments>(arguments)...);
    block->destroy = [](detail::SharedBlock* base) noexcept {
        Block* made = static_cast<Block*>(base);
        Allocator* from = made->allocator;
        made->~Block();
        from->Deallocate(made, sizeof(Block));
    };
    Shared<T> shared;
    shared.object_ = &block->object;
    shared.block_ = block;
    return shared;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
