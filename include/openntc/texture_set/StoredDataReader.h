// SPDX-License-Identifier: MIT
// Stability: internal
// Data of a file that may be compressed.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <cstddef>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

class StoredDataReader {
public:
    StoredDataReader(Stream& stream, Allocator& allocator) noexcept
        : stream_(&stream), compressed_(allocator) {}

    /// The first bytes of the data; as many as `destination` has must be there. `what` names them in
    /// messages. Errors: IOError; FileUnrecognized for compressed data that are corrupt; OutOfMemory.
    Expected<void> Read(const StoredData& data, std::span<std::byte> destination, const char* what) noexcept {
        if (data.isCompressed)
            return Fail(Status::NotImplemented, "%s: compressed: cannot be read yet", what);
        if (!stream_->ReadAt(data.range.offset, destination.data(), destination.size()))
            return Fail(Status::IOError, "%s: %zu bytes at %llu: cannot be read", what, destination.size(),
                        static_cast<unsigned long long>(data.range.offset));
        return {};
    }

private:
    Stream* stream_;
    Array<std::byte> compressed_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
