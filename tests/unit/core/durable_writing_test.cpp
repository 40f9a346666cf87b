// SPDX-License-Identifier: MIT
// A file is named only when its bytes are on the disk, and a failure to bring them there is reported.
#include "openntc/core/FileStream.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#if defined(__linux__)
#include <csignal>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace {

/// What one fsync was asked to bring to the disk, and whether the destination had its name by then.
struct SyncCall {
    bool isFolder = false;
    bool hasDestination = false;
};
std::vector<SyncCall>* syncCalls = nullptr;
std::filesystem::path watchedDestination;
int failingSync = -1; // the number of the call that fails as if the disk were broken

} // namespace

// Stands before the C library's: the test sees the calls, and can make one fail.
extern "C" int fsync(int descriptor) {
    if (syncCalls != nullptr) {
        struct stat status = {};
        fstat(descriptor, &status);
        syncCalls->push_back({S_ISDIR(status.st_mode), std::filesystem::exists(watchedDestination)});
        if (failingSync == static_cast<int>(syncCalls->size()) - 1) {
            errno = EIO;
            return -1;
        }
    }
    return static_cast<int>(syscall(SYS_fsync, descriptor));
}
#endif

using namespace openntc;

#if defined(__linux__)
namespace {

class Watch {
public:
    explicit Watch(const std::filesystem::path& destination, int failing = -1) {
        watchedDestination = destination;
        failingSync = failing;
        syncCalls = &calls;
    }
    ~Watch() { syncCalls = nullptr; }

    std::vector<SyncCall> calls;
};

struct EmptyFolder {
    EmptyFolder() : path(std::filesystem::temp_directory_path() / "openntc_durable") {
        std::filesystem::remove_all(path);
        std::filesystem::create_directories(path);
    }
    ~EmptyFolder() { std::filesystem::remove_all(path); }
    std::filesystem::path path;
};

bool Names(const Expected<void>& result, std::string_view text) {
    return !result && std::string_view(result.error().GetText()).find(text) != std::string_view::npos;
}

} // namespace

TEST_CASE("files: the bytes are on the disk before the name, and the name after it") {
    const EmptyFolder folder;
    const std::filesystem::path path = folder.path / "set.ntc";
    Expected<FileWriter> writer = FileWriter::Create(path);
    REQUIRE(writer);
    REQUIRE(writer->Write("0123456789", 10));
    const Watch watch(path);
    REQUIRE(writer->Commit());
    REQUIRE(watch.calls.size() == 2);
    CHECK_FALSE(watch.calls[0].isFolder);
    CHECK_FALSE(watch.calls[0].hasDestination);
    CHECK(watch.calls[1].isFolder);
    CHECK(watch.calls[1].hasDestination);
}

TEST_CASE("files: a disk that fails is reported, and the destination stays as it was") {
    const EmptyFolder folder;
    const std::filesystem::path path = folder.path / "set.ntc";
    Expected<FileWriter> writer = FileWriter::Create(path);
    REQUIRE(writer);
    REQUIRE(writer->Write("0123456789", 10));
    const Watch watch(path, 0);
    const Expected<void> result = writer->Commit();
    CHECK(Names(result, "Input/output error"));
    CHECK(std::filesystem::is_empty(folder.path));
}

TEST_CASE("files: a folder whose names cannot be brought to the disk is reported") {
    const EmptyFolder folder;
    const std::filesystem::path path = folder.path / "set.ntc";
    Expected<FileWriter> writer = FileWriter::Create(path);
    REQUIRE(writer);
    const Watch watch(path, 1);
    const Expected<void> result = writer->Commit();
    CHECK(Names(result, "folder"));
    CHECK(SyncFile(folder.path / "absent").error().GetStatus() == Status::IOError);
}

// The bytes of a small file wait in the stream's own buffer: only the flush in Commit can notice that they do not fit.
TEST_CASE("files: a flush that fails is not a success") {
    const EmptyFolder folder;
    const std::filesystem::path path = folder.path / "set.ntc";
    Expected<FileWriter> writer = FileWriter::Create(path);
    REQUIRE(writer);
    REQUIRE(writer->Write("0123456789", 10));
    rlimit before = {};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit tight = {4, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    const Expected<void> result = writer->Commit();
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    CHECK(Names(result, "File too large"));
    CHECK(std::filesystem::is_empty(folder.path));
}
#else
TEST_CASE("files: the bytes are on the disk before the name") {
    MESSAGE("SKIP: the calls to the system are watched on Linux only");
}
#endif

TEST_CASE("files: errors say the system's reason") {
    const std::filesystem::path absent =
        std::filesystem::temp_directory_path() / "openntc_absent" / "set.ntc";
    const std::string reason = SystemReason(ENOENT).GetText();
    CHECK(reason.size() > 4);
    CHECK(std::string(FileReader::Open(absent).error().GetText()) ==
          "cannot be opened for reading: " + reason);
    CHECK(std::string(FileWriter::Create(absent).error().GetText()) == "cannot be created: " + reason);
    CHECK(std::string(SystemReason(987654).GetText()) != "");
}
