// SPDX-License-Identifier: MIT
// Stability: experimental
// Keeps what compressed latents are decompressed to. GDeflate has tiles of 64 KiB, and a tile of a texture
// set wants a few rows of some of them, as do its neighbours: without a cache each decompresses them again.
#pragma once

#include "openntc/container/GDeflate.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/Shared.h"
#include "openntc/core/Stream.h"
#include "openntc/streaming/detail/Threads.h"
#include "openntc/texture_set/StoredDataReader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {
class CachedDataReader;
}

struct DecompressedTileStatistics {
    std::uint64_t decompressed = 0; ///< tiles of 64 KiB
    std::uint64_t found = 0;        ///< that were there
    std::size_t bytes = 0;          ///< of memory that is taken, at most what was allowed
};

/// Several sources (TextureSetTileSource) may share one, from any threads. The tile that was used last
/// longest ago leaves first.
class DecompressedTileCache {
public:
    static constexpr std::size_t kTileBytes = container::kGDeflateTileBytes;
    static constexpr std::size_t kMaxTiles = 4096;

    /// For `tiles` = 1 … 4096 tiles, whose memory is taken when it is needed. The allocator is called by one
    /// thread at a time, and must outlive the cache. Errors: OutOfRange, OutOfMemory.
    static Expected<Shared<DecompressedTileCache>> Create(std::size_t tiles,
                                                          Allocator& allocator = GetDefaultAllocator()) {
        if (tiles < 1 || tiles > kMaxTiles)
            return Fail(Status::OutOfRange, "tiles: %zu: must be 1 … %zu", tiles, kMaxTiles);
        OPENNTC_ASSIGN(Shared<DecompressedTileCache> cache,
                       MakeShared<DecompressedTileCache>(allocator, allocator));
        OPENNTC_CHECK(cache->entries_.Reserve(tiles));
        for (std::size_t i = 0; i < tiles; ++i)
            OPENNTC_CHECK(cache->entries_.PushBack(Entry(allocator)));
        return cache;
    }

    DecompressedTileStatistics GetStatistics() const {
        const detail::Lock lock(mutex_);
        return statistics_;
    }

private:
    friend class detail::CachedDataReader;
    template <typename Made, typename... Arguments>
    friend Expected<Shared<Made>> MakeShared(Allocator& allocator, Arguments&&... arguments);

    struct Key {
        std::uint64_t source = 0;
        std::uint64_t offset = 0; ///< of the compressed data in the source
        std::uint32_t tile = 0;

        friend bool operator==(const Key&, const Key&) noexcept = default;
    };
    enum class State { Empty, Loading, Ready };
    struct Entry {
        explicit Entry(Allocator& allocator) noexcept : bytes(allocator) {}

        Array<std::byte> bytes;
        Key key;
        State state = State::Empty;
        std::uint32_t users = 0;
        std::uint64_t lastUse = 0;
    };

    explicit DecompressedTileCache(Allocator& allocator) noexcept : entries_(allocator) {}

    std::uint64_t AddSource() {
        const detail::Lock lock(mutex_);
        return ++lastSource_;
    }

    /// The tile, which nobody else gets the place of before Give. A thread has one at a time, so none waits
    /// for itself. `load` fills a span of its bytes; the thread that comes first calls it, others wait.
    template <typename Load>
    Expected<Entry*> Take(const Key& key, std::size_t bytes, Load&& load) {
        detail::Lock lock(mutex_);
        Entry* entry = nullptr;
        const auto find = [&] {
            entry = Find(key);
            if (entry == nullptr)
                entry = FindOldest();
            return entry != nullptr && entry->state != State::Loading;
        };
        changed_.Wait(lock, find);
        ++entry->users;
        entry->lastUse = ++clock_;
        if (entry->state == State::Ready && entry->key == key) {
            ++statistics_.found;
            return entry;
        }
        entry->key = key;
        entry->state = State::Loading;
        Expected<void> loaded = Enlarge(*entry);
        if (loaded) {
            lock.unlock();
            loaded = load(entry->bytes.AsSpan().first(bytes));
            lock.lock();
        }
        entry->state = loaded ? State::Ready : State::Empty;
        statistics_.decompressed += loaded ? 1u : 0u;
        entry->users -= loaded ? 0u : 1u;
        changed_.NotifyAll();
        if (!loaded)
            return PassError(loaded);
        return entry;
    }

    void Give(Entry& entry) {
        const detail::Lock lock(mutex_);
        --entry.users;
        changed_.NotifyAll();
    }

    Expected<void> Enlarge(Entry& entry) noexcept {
        if (!entry.bytes.empty())
            return {};
        OPENNTC_CHECK(entry.bytes.Resize(kTileBytes));
        statistics_.bytes += kTileBytes;
        return {};
    }
    Entry* Find(const Key& key) noexcept {
        for (Entry& entry : entries_) {
            if (entry.state != State::Empty && entry.key == key)
                return &entry;
        }
        return nullptr;
    }
    /// Null: all are in use.
    Entry* FindOldest() noexcept {
        Entry* oldest = nullptr;
        for (Entry& entry : entries_) {
            if (entry.users == 0 && (oldest == nullptr || entry.lastUse < oldest->lastUse))
                oldest = &entry;
        }
        return oldest;
    }

    mutable detail::Mutex mutex_;
    detail::Condition changed_;
    Array<Entry> entries_;
    std::uint64_t clock_ = 0;
    std::uint64_t lastSource_ = 0;
    DecompressedTileStatistics statistics_;
};

namespace detail {

/// StoredDataReader's ReadPart for compressed data, through a cache.
class CachedDataReader {
public:
    /// `source` is a number of the cache's own (GetNewSource).
    CachedDataReader(Stream& stream, Allocator& allocator, DecompressedTileCache& cache,
                     std::uint64_t source) noexcept
        : reader_(stream, allocator), cache_(cache), source_(source) {}
    CachedDataReader(const CachedDataReader&) = delete;
    CachedDataReader& operator=(const CachedDataReader&) = delete;
    ~CachedDataReader() { Release(); }

    static std::uint64_t GetNewSource(DecompressedTileCache& cache) { return cache.AddSource(); }

    Expected<void> ReadPart(const StoredData& data, std::uint64_t offset, std::span<std::byte> destination,
                            const char* what) {
        while (!destination.empty()) {
            const std::uint64_t tile = offset / DecompressedTileCache::kTileBytes;
            const auto begin = static_cast<std::size_t>(offset % DecompressedTileCache::kTileBytes);
            OPENNTC_ASSIGN(const std::span<const std::byte> bytes, GetTile(data, tile, what));
            const std::size_t used = std::min(bytes.size() - begin, destination.size());
            std::memcpy(destination.data(), bytes.data() + begin, used);
            destination = destination.subspan(used);
            offset += used;
        }
        return {};
    }

private:
    Expected<std::span<const std::byte>> GetTile(const StoredData& data, std::uint64_t tile,
                                                 const char* what) {
        const std::uint64_t first = tile * DecompressedTileCache::kTileBytes;
        const auto bytes = static_cast<std::size_t>(
            std::min<std::uint64_t>(DecompressedTileCache::kTileBytes, data.bytes - first));
        const DecompressedTileCache::Key key{source_, data.range.offset, static_cast<std::uint32_t>(tile)};
        if (entry_ == nullptr || entry_->key != key) {
            Release();
            OPENNTC_ASSIGN(entry_, cache_.Take(key, bytes, [&](std::span<std::byte> to) {
                return reader_.ReadPart(data, first, to, what);
            }));
        }
        return entry_->bytes.AsSpan().first(bytes);
    }
    void Release() {
        if (entry_ != nullptr)
            cache_.Give(*std::exchange(entry_, nullptr));
    }

    StoredDataReader reader_;
    DecompressedTileCache& cache_;
    std::uint64_t source_;
    DecompressedTileCache::Entry* entry_ = nullptr;
};

} // namespace detail

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
