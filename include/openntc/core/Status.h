// SPDX-License-Identifier: MIT
// Stability: stable
// Result codes shared by every OpenNTC function.
#pragma once

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What went wrong. Names, numbers and meanings follow the status codes of LibNTC 0.7, so that engines can
/// map one to the other; codes that concern CUDA or LibNTC's own context have no counterpart here and their
/// numbers stay unused.
enum class Status : std::uint32_t {
    Ok = 0,
    FileUnavailable = 4,  ///< a file cannot be opened, created or renamed
    FileUnrecognized = 5, ///< the bytes are not a texture set that this version understands
    FileIncompatible = 6, ///< a valid file that does not fit what it is loaded into
    Incomplete = 7,       ///< more work or a larger buffer is needed
    Unsupported = 8,      ///< a valid request that this set or build has no data or code for
    InternalError = 9,    ///< a promise of the library was broken; please report it
    InvalidArgument = 10, ///< an argument is null, of the wrong kind or contradicts another
    InvalidState = 11,    ///< the object cannot do this now
    IOError = 12,         ///< reading, writing or seeking failed
    NotImplemented = 13,  ///< a part of the format that no reader implements yet
    OutOfMemory = 14,     ///< the allocator returned null
    OutOfRange = 15,      ///< a number is outside its documented range
    ShaderUnavailable = 16,
    UnknownError = 17,
};

/// The same, for sources that include X11's headers, where Status is a macro.
using StatusCode = Status;

/// The enumerator's name, for example "FileUnrecognized"; "UnknownStatus" for values that are not
/// enumerators.
constexpr const char* StatusToString(Status status) noexcept {
    switch (status) {
    case Status::Ok:
        return "Ok";
    case Status::FileUnavailable:
        return "FileUnavailable";
    case Status::FileUnrecognized:
        return "FileUnrecognized";
    case Status::FileIncompatible:
        return "FileIncompatible";
    case Status::Incomplete:
        return "Incomplete";
    case Status::Unsupported:
        return "Unsupported";
    case Status::InternalError:
        return "InternalError";
    case Status::InvalidArgument:
        return "InvalidArgument";
    case Status::InvalidState:
        return "InvalidState";
    case Status::IOError:
        return "IOError";
    case Status::NotImplemented:
        return "NotImplemented";
    case Status::OutOfMemory:
        return "OutOfMemory";
    case Status::OutOfRange:
        return "OutOfRange";
    case Status::ShaderUnavailable:
        return "ShaderUnavailable";
    case Status::UnknownError:
        return "UnknownError";
    }
    return "UnknownStatus";
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
