// SPDX-License-Identifier: MIT
// Stability: internal
// An array of which only the parts that were touched take memory: what is kept for each of many pages, most
// of
// which nobody ever asks for.
#pragma once

#include "openntc/core/Allocator.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

template <typename T>
class ChunkedArray {
    static_assert(std::is_trivially_copyable_v<T>);

public:
    explicit ChunkedArray(Allocator& allocator) noexcept : chunks_(allocator) {}
    ChunkedArray(const ChunkedArray&) = delete;
    ChunkedArray& operator=(const ChunkedArray&) = delete;
    ~ChunkedArray() {
        for (T* chunk : chunks_) {
            if (chunk != nullptr)
                chunks_.GetAllocator().Deallocate(chunk, kChunk * sizeof(T));
        }
    }

    /// To be called once. Costs a pointer for each kChunk elements.
    Expected<void> SetSize(std::uint32_t size) noexcept {
        return chunks_.Resize((std::size_t{size} + kChunk - 1) / kChunk);
    }

    /// Null where nothing was touched.
    T* Find(std::uint32_t index) const noexcept {
        T* chunk = chunks_[index / kChunk];
        return chunk == nullptr ? nullptr : chunk + index % kChunk;
    }

    /// New elements are T().
    Expected<T*> Touch(std::uint32_t index) noexcept {
        T*& chunk = chunks_[index / kChunk];
        if (chunk == nullptr) {
            void* memory = chunks_.GetAllocator().Allocate(kChunk * sizeof(T));
            if (memory == nullptr)
                return Fail(Status::OutOfMemory, "allocation: %zu bytes: refused by the allocator",
                            kChunk * sizeof(T));
            chunk = static_cast<T*>(memory);
            for (std::size_t i = 0; i < kChunk; ++i)
                ::new (static_cast<void*>(chunk + i)) T();
        }
        return chunk + index % kChunk;
    }

private:
    static constexpr std::size_t kChunk = 256;

    Array<T*> chunks_;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
