// SPDX-License-Identifier: MIT
// Stability: stable
// Streams on files: reading, and writing under a temporary name that is renamed when everything is there.
#pragma once

#include "openntc/core/FileCalls.h"
#include "openntc/core/Stream.h"

#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Reads a file. Open with FileReader::Open. Size is that at opening; seeking past it fails.
class FileReader final : public Stream {
public:
    static Expected<FileReader> Open(const std::filesystem::path& path) noexcept {
        std::error_code ignored;
        if (std::filesystem::is_directory(path, ignored))
            return Fail(Status::FileUnavailable, "is a directory");
        std::FILE* file = detail::OpenForReading(path);
        if (file == nullptr)
            return Fail(Status::FileUnavailable, "cannot be opened for reading: %s",
                        SystemReason(errno).GetText());
        if (!detail::SeekFile(file, 0, SEEK_END)) {
            std::fclose(file);
            return Fail(Status::FileUnavailable, "is not seekable");
        }
        const std::uint64_t size = detail::TellFile(file);
        std::rewind(file);
        return FileReader(file, size);
    }

    FileReader(FileReader&& other) noexcept
        : file_(std::exchange(other.file_, nullptr)), size_(other.size_) {}
    FileReader& operator=(FileReader&& other) noexcept {
        std::swap(file_, other.file_);
        std::swap(size_, other.size_);
        return *this;
    }
    ~FileReader() override {
        if (file_ != nullptr)
            std::fclose(file_);
    }

    bool Read(void* destination, std::size_t bytes) noexcept override {
        return bytes == 0 || std::fread(destination, 1, bytes, file_) == bytes;
    }
    bool ReadAt(std::uint64_t offset, void* destination, std::size_t bytes) noexcept override {
        return offset <= size_ && bytes <= size_ - offset &&
               detail::ReadFileAt(file_, offset, destination, bytes);
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override {
        return offset <= size_ && detail::SeekFile(file_, offset, SEEK_SET);
    }
    std::uint64_t Tell() noexcept override { return detail::TellFile(file_); }
    std::uint64_t Size() noexcept override { return size_; }

private:
    FileReader(std::FILE* file, std::uint64_t size) noexcept : file_(file), size_(size) {}

    std::FILE* file_;
    std::uint64_t size_;
};

/// Writes a file so that readers never see a part of it: bytes go to a temporary name in the same folder, and
/// Commit renames it over the destination. Without Commit the temporary file is removed and the destination
/// is untouched.
class FileWriter final : public Stream {
public:
    static Expected<FileWriter> Create(const std::filesystem::path& path) {
        // Creation is exclusive, so that the name need not be secret, only unlikely to exist.
        static std::atomic<std::uint64_t> counter{0};
        int error = 0;
        for (int attempt = 0; attempt < 16; ++attempt) {
            const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
            const auto unique = (static_cast<std::uint64_t>(now) << 8) + counter.fetch_add(1);
            char suffix[32];
            std::snprintf(suffix, sizeof(suffix), ".%llx.tmp", static_cast<unsigned long long>(unique));
            std::filesystem::path temporary = path;
            temporary += suffix;
            if (std::FILE* file = detail::CreateForWriting(temporary))
                return FileWriter(file, path, std::move(temporary));
            error = errno;
        }
        return Fail(Status::FileUnavailable, "cannot be created: %s", SystemReason(error).GetText());
    }

    FileWriter(FileWriter&& other) noexcept
        : file_(std::exchange(other.file_, nullptr)), path_(std::move(other.path_)),
          temporary_(std::move(other.temporary_)) {}
    FileWriter& operator=(FileWriter&&) = delete;
    ~FileWriter() override { Discard(); }

    bool Read(void*, std::size_t) noexcept override { return false; }
    bool Write(const void* source, std::size_t bytes) noexcept override {
        return bytes == 0 || std::fwrite(source, 1, bytes, file_) == bytes;
    }
    bool Seek(std::uint64_t offset) noexcept override { return detail::SeekFile(file_, offset, SEEK_SET); }
    std::uint64_t Tell() noexcept override { return detail::TellFile(file_); }
    std::uint64_t Size() noexcept override {
        const std::uint64_t position = Tell();
        if (!detail::SeekFile(file_, 0, SEEK_END))
            return 0;
        const std::uint64_t size = Tell();
        return Seek(position) ? size : 0;
    }

    /// Flushes, forces the bytes to the disk, closes, renames, and forces the folder's names to the disk.
    /// After it, or after its failure, the writer can only be destroyed; after a failure before the renaming
    /// the destination is as it was. Errors: IOError with the system's reason.
    Expected<void> Commit() {
        bool complete = detail::FlushToDisk(file_);
        std::error_code error(errno, std::generic_category());
        if (std::fclose(std::exchange(file_, nullptr)) != 0 && complete) {
            error.assign(errno, std::generic_category());
            complete = false;
        }
        if (complete) {
            std::filesystem::rename(temporary_, path_, error);
            complete = !error;
        }
        if (!complete) {
            std::error_code ignored;
            std::filesystem::remove(temporary_, ignored);
            return Fail(Status::IOError, "writing: the destination: cannot be completed: %s",
                        SystemReason(error.default_error_condition().value()).GetText());
        }
        return SyncFolder(path_.parent_path());
    }

private:
    FileWriter(std::FILE* file, std::filesystem::path path, std::filesystem::path temporary) noexcept
        : file_(file), path_(std::move(path)), temporary_(std::move(temporary)) {}

    void Discard() noexcept {
        if (file_ == nullptr)
            return;
        std::fclose(std::exchange(file_, nullptr));
        std::error_code ignored;
        std::filesystem::remove(temporary_, ignored);
    }

    std::FILE* file_;
    std::filesystem::path path_;
    std::filesystem::path temporary_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
