// SPDX-License-Identifier: MIT
// Stability: internal
// The calls to the system that file streams need: 64-bit positions, exclusive creation, bytes forced to the
// disk, reasons.
#pragma once

#include "openntc/core/Expected.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#include <sys/stat.h>
#else
#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>
#endif

#include "openntc/core/HideMacros.h"

namespace openntc {

/// The system's words for an errno, for example "No space left on device"; never allocates.
class SystemReason {
public:
    explicit SystemReason(int error) noexcept {
#if defined(_WIN32)
        if (strerror_s(text_, sizeof text_, error) != 0)
            text_[0] = '\0';
#else
        Take(strerror_r(error, text_, sizeof text_));
#endif
        if (text_[0] == '\0')
            std::snprintf(text_, sizeof text_, "error %d", error);
    }

    /// Never null, NUL-terminated.
    const char* GetText() const noexcept {
        return text_;
    }

private:
    // GNU's strerror_r returns the text, which need not be in the buffer; POSIX's fills the buffer.
    void Take(const char* text) noexcept {
        if (text != text_)
            std::snprintf(text_, sizeof text_, "%s", text);
    }
    void Take(int failed) noexcept {
        if (failed != 0)
            text_[0] = '\0';
    }

    char text_[128] = {};
};

namespace detail {

inline std::FILE* OpenForReading(const std::filesystem::path& path) noexcept {
#if defined(_WIN32)
    return _wfopen(path.c_str(), L"rb");
#else
    return std::fopen(path.c_str(), "rb");
#endif
}

/// Creates a file that must not exist yet.
inline std::FILE* CreateForWriting(const std::filesystem::path& path) noexcept {
#if defined(_WIN32)
    // The "x" mode of fopen is not in every C runtime of Windows.
    const int descriptor =
        _wopen(path.c_str(), _O_WRONLY | _O_CREAT | _O_EXCL | _O_BINARY, _S_IREAD | _S_IWRITE);
    if (descriptor < 0)
        return nullptr;
    std::FILE* file = _fdopen(descriptor, "wb");
    if (file == nullptr)
        _close(descriptor);
    return file;
#else
    return std::fopen(path.c_str(), "wbx");
#endif
}

inline bool SeekFile(std::FILE* file, std::uint64_t offset, int origin) noexcept {
    if (offset > static_cast<std::uint64_t>((std::numeric_limits<std::int64_t>::max)()))
        return false;
#if defined(_WIN32)
    return _fseeki64(file, static_cast<std::int64_t>(offset), origin) == 0;
#else
    return fseeko(file, static_cast<off_t>(offset), origin) == 0;
#endif
}

inline std::uint64_t TellFile(std::FILE* file) noexcept {
#if defined(_WIN32)
    const std::int64_t position = _ftelli64(file);
#else
    const off_t position = ftello(file);
#endif
    return position < 0 ? 0 : static_cast<std::uint64_t>(position);
}

/// Reads without the stream's buffer, which would fetch a block of it for every few bytes, in one call of the
/// system. Where there is none that takes a position, the stream is moved.
inline bool ReadFileAt(std::FILE* file, std::uint64_t offset, void* destination, std::size_t bytes) noexcept {
#if defined(_WIN32)
    return SeekFile(file, offset, SEEK_SET) &&
           (bytes == 0 || std::fread(destination, 1, bytes, file) == bytes);
#else
    if (offset > static_cast<std::uint64_t>((std::numeric_limits<off_t>::max)()) - bytes)
        return false;
    char* to = static_cast<char*>(destination);
    while (bytes > 0) {
        const ssize_t got = pread(fileno(file), to, bytes, static_cast<off_t>(offset));
        if (got == 0 || (got < 0 && errno != EINTR))
            return false;
        const std::size_t arrived = got < 0 ? 0 : static_cast<std::size_t>(got);
        to += arrived;
        offset += arrived;
        bytes -= arrived;
    }
    return true;
#endif
}

/// The stream's own buffer, and then the system's, to the disk. False with errno.
inline bool FlushToDisk(std::FILE* file) noexcept {
    if (std::fflush(file) != 0)
        return false;
#if defined(_WIN32)
    return _commit(_fileno(file)) == 0;
#else
    return fsync(fileno(file)) == 0;
#endif
}

} // namespace detail

/// Forces the bytes of a file that is already written and closed to the disk. Errors: IOError with the
/// system's reason.
inline Expected<void> SyncFile(const std::filesystem::path& path) noexcept {
#if defined(_WIN32)
    std::FILE* file = _wfopen(path.c_str(), L"r+b");
#else
    std::FILE* file = detail::OpenForReading(path);
#endif
    bool synced = file != nullptr && detail::FlushToDisk(file);
    const int error = errno;
    if (file != nullptr)
        synced = std::fclose(file) == 0 && synced;
    if (!synced)
        return Fail(Status::IOError, "cannot be completed: %s", SystemReason(error).GetText());
    return {};
}

/// Forces the names in a folder to the disk, so that a rename outlives a loss of power. `folder` empty: the
/// current one. Windows and some file systems offer no such call: nothing is done there. Errors: IOError with
/// the system's reason.
inline Expected<void> SyncFolder([[maybe_unused]] const std::filesystem::path& folder) noexcept {
#if !defined(_WIN32)
    const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return {}; // a folder may be writable and not readable
    const bool synced = fsync(descriptor) == 0;
    const int error = errno;
    close(descriptor);
    if (!synced && error != EINVAL && error != ENOTSUP)
        return Fail(Status::IOError, "folder: cannot be completed: %s", SystemReason(error).GetText());
#endif
    return {};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
