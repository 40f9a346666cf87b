// SPDX-License-Identifier: MIT
// Real files of LibNTC: they are read, and writing their documents again gives their JSON text byte for byte.
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

#include <string>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

TEST_CASE("conformance: the JSON of every file is reproduced, and the file") {
    const std::vector<std::filesystem::path> files = ConformanceFiles();
    if (files.empty())
        MESSAGE("SKIP: no conformance vectors in " << (SharedFolder() / "conformance").string());
    for (const std::filesystem::path& path : files) {
        const std::string name = path.filename().string();
        CAPTURE(name);
        const std::string bytes = ReadWholeFile(path);
        const Expected<Container> container = ReadBytes(bytes);
        REQUIRE_MESSAGE(container, std::string(container.error().GetText()));
        HeaderBytes headerBytes;
        std::memcpy(headerBytes.data(), bytes.data(), headerBytes.size());
        const Expected<Header> header = DecodeHeader(headerBytes, bytes.size());
        REQUIRE(header);
        CHECK(FormatToString(container->document) == bytes.substr(header->jsonOffset, header->jsonSize - 1));

        // The whole file, since LibNTC lays out views as our writer does.
        std::vector<std::span<const std::byte>> views;
        const std::span<const std::byte> chunk =
            std::as_bytes(std::span(bytes.data(), bytes.size())).subspan(container->binaryOffset);
        for (const BufferView& view : container->document.views)
            views.push_back(chunk.subspan(view.offset, view.storedSize));
        MemoryStream stream;
        const Expected<void> written = WriteContainer(stream, {&container->document, views});
        REQUIRE_MESSAGE(written, std::string(written.error().GetText()));
        const std::span<const std::byte> copy = stream.GetBytes();
        CHECK(std::string(reinterpret_cast<const char*>(copy.data()), copy.size()) == bytes);
    }
}
