// SPDX-License-Identifier: MIT
// Streams in memory and on files: limits, positions, and that a file appears only when it is complete.
#include "openntc/core/FileStream.h"
#include "openntc/core/Stream.h"
#include "support/CountingAllocator.h"

#include <doctest/doctest.h>

#include <cstring>
#include <iterator>
#include <limits>
#include <string>

using namespace openntc;

namespace {

class TestFolder {
public:
    TestFolder() : path_(std::filesystem::temp_directory_path() / "openntc_unit_core") {
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    const std::filesystem::path& GetPath() const { return path_; }
    auto CountFiles() const { return std::distance(std::filesystem::directory_iterator(path_), {}); }

private:
    std::filesystem::path path_;
};

void CheckReading(Stream& stream, const std::string& content) {
    std::string buffer(content.size() + 1, '\0');
    CHECK(stream.Size() == content.size());
    CHECK(stream.Tell() == 0);
    CHECK_FALSE(stream.Read(buffer.data(), content.size() + 1));
    REQUIRE(stream.Seek(0));
    REQUIRE(stream.Read(buffer.data(), content.size()));
    CHECK(buffer.substr(0, content.size()) == content);
    CHECK(stream.Tell() == content.size());
    CHECK(stream.Read(buffer.data(), 0));
    CHECK_FALSE(stream.Read(buffer.data(), 1));
    CHECK(stream.Seek(content.size()));
    CHECK_FALSE(stream.Seek(content.size() + 1));
    CHECK_FALSE(stream.Seek(std::numeric_limits<std::uint64_t>::max()));
    REQUIRE(stream.Seek(2));
    REQUIRE(stream.Read(buffer.data(), 1));
    CHECK(buffer[0] == content[2]);

    REQUIRE(stream.ReadAt(3, buffer.data(), content.size() - 3));
    CHECK(buffer.substr(0, content.size() - 3) == content.substr(3));
    CHECK(stream.ReadAt(content.size(), buffer.data(), 0));
    CHECK_FALSE(stream.ReadAt(content.size(), buffer.data(), 1));
    CHECK_FALSE(stream.ReadAt(3, buffer.data(), content.size() - 2));
    CHECK_FALSE(stream.ReadAt(std::numeric_limits<std::uint64_t>::max(), buffer.data(), 1));
    CHECK_FALSE(stream.ReadAt(content.size() + 1, buffer.data(), 0));
    REQUIRE(stream.Seek(4)); // reading goes on from where it is told
    REQUIRE(stream.Read(buffer.data(), 1));
    CHECK(buffer[0] == content[4]);
}

} // namespace

TEST_CASE("memory streams: reading, writing over and past the end, exhaustion") {
    const std::string content = "0123456789";
    ReadOnlyMemoryStream readOnly(std::as_bytes(std::span(content)));
    CheckReading(readOnly, content);
    CHECK_FALSE(readOnly.Write("x", 1));

    openntc::test::CountingAllocator allocator;
    MemoryStream stream(allocator);
    REQUIRE(stream.Write("01234", 5));
    REQUIRE(stream.Seek(3));
    REQUIRE(stream.Write("3456789", 7));
    REQUIRE(stream.Seek(0));
    CheckReading(stream, content);
    CHECK(stream.GetBytes().size() == 10);
    allocator.SetLimit(allocator.GetUsedBytes());
    const std::string much(1000, 'x');
    CHECK_FALSE(stream.Write(much.data(), much.size()));
    CHECK(stream.Size() == 10);
}

TEST_CASE("files: reading") {
    const TestFolder folder;
    const std::filesystem::path path = folder.GetPath() / "content";
    Expected<FileWriter> writer = FileWriter::Create(path);
    REQUIRE(writer);
    REQUIRE(writer->Write("0123456789", 10));
    REQUIRE(writer->Commit());
    Expected<FileReader> reader = FileReader::Open(path);
    REQUIRE(reader);
    CheckReading(*reader, "0123456789");
    CHECK_FALSE(reader->Write("x", 1));
    FileReader moved(std::move(*reader));
    CHECK(moved.Size() == 10);

#if !defined(_WIN32)                       // whose reads go through a buffer, which may still have them
    std::filesystem::resize_file(path, 5); // by somebody else
    char byte = 0;
    CHECK(moved.ReadAt(4, &byte, 1));
    CHECK_FALSE(moved.ReadAt(6, &byte, 1));
#endif

    for (const std::filesystem::path& bad : {folder.GetPath(), folder.GetPath() / "absent"}) {
        const Expected<FileReader> none = FileReader::Open(bad);
        REQUIRE_FALSE(none);
        CHECK(none.error().GetStatus() == Status::FileUnavailable);
    }
}

TEST_CASE("files: a writer leaves nothing without Commit and replaces the destination with it") {
    const TestFolder folder;
    const std::filesystem::path path = folder.GetPath() / "set.ntc";
    const auto write = [&path](const char* text, bool commit) {
        Expected<FileWriter> writer = FileWriter::Create(path);
        REQUIRE(writer);
        REQUIRE(writer->Write(text, std::strlen(text)));
        CHECK(writer->Size() == std::strlen(text));
        CHECK(writer->Tell() == std::strlen(text));
        char byte = 0;
        CHECK_FALSE(writer->Read(&byte, 1));
        if (commit)
            REQUIRE(writer->Commit());
    };
    write("discarded", false);
    CHECK(folder.CountFiles() == 0);
    write("first", true);
    write("discarded", false);
    CHECK(folder.CountFiles() == 1);
    CHECK(FileReader::Open(path)->Size() == 5);
    write("replacement", true);
    CHECK(folder.CountFiles() == 1);
    CHECK(FileReader::Open(path)->Size() == 11);
    const Expected<FileWriter> none = FileWriter::Create(folder.GetPath() / "absent" / "set.ntc");
    REQUIRE_FALSE(none);
    CHECK(none.error().GetStatus() == Status::FileUnavailable);
}

TEST_CASE(
    "files: two writers of one destination do not disturb each other; a destination that is a folder fails") {
    const TestFolder folder;
    const std::filesystem::path path = folder.GetPath() / "set.ntc";
    Expected<FileWriter> one = FileWriter::Create(path);
    Expected<FileWriter> two = FileWriter::Create(path);
    REQUIRE(one);
    REQUIRE(two);
    REQUIRE(one->Write("1", 1));
    REQUIRE(two->Write("22", 2));
    REQUIRE(two->Commit());
    REQUIRE(one->Commit());
    CHECK(FileReader::Open(path)->Size() == 1);
    CHECK(folder.CountFiles() == 1);

    const std::filesystem::path taken = folder.GetPath() / "folder";
    std::filesystem::create_directories(taken / "inner");
    Expected<FileWriter> blocked = FileWriter::Create(taken);
    REQUIRE(blocked);
    const Expected<void> committed = blocked->Commit();
    REQUIRE_FALSE(committed);
    CHECK(committed.error().GetStatus() == Status::IOError);
    CHECK(folder.CountFiles() == 2);
}
