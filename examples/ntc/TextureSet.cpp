// SPDX-License-Identifier: MIT
#include "TextureSet.h"

#include "Failure.h"

#include "openntc/container/Schema.h"
#include "openntc/core/FileStream.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#endif

namespace openntc::tool {

namespace {

enum class PipeContent { Any, TextureSet };

/// False for what cannot become a texture set, however long it is: a device or pipe may have no end.
bool MayBeTextureSet(std::span<const std::byte> beginning) {
    const std::span<const std::byte> signature = std::as_bytes(std::span("NTEX", 4));
    return beginning.size() < signature.size() ||
           std::equal(signature.begin(), signature.end(), beginning.begin());
}

// Pipes have no size and cannot seek: read to the end.
std::vector<std::byte> ReadToEnd(std::FILE* file, const std::string& name, PipeContent content) {
    constexpr std::size_t kChunk = 1u << 16;
    std::vector<std::byte> bytes;
    while (content == PipeContent::Any || MayBeTextureSet(bytes)) {
        const std::size_t size = bytes.size();
        bytes.resize(size + kChunk);
        const std::size_t count = std::fread(bytes.data() + size, 1, kChunk, file);
        bytes.resize(size + count);
        if (count < kChunk)
            break;
    }
    if (std::ferror(file) != 0)
        throw CommandError(ExitCode::BadInput, name, "file: cannot be read");
    return bytes;
}

bool IsPipe(const std::string& path) {
    std::error_code ignored;
    const std::filesystem::file_type type = std::filesystem::status(path, ignored).type();
    return path == "-" || type == std::filesystem::file_type::fifo ||
           type == std::filesystem::file_type::character;
}

std::vector<std::byte> ReadPipe(const std::string& path, PipeContent content) {
    if (path == "-") {
#if defined(_WIN32)
        _setmode(_fileno(stdin), _O_BINARY);
#endif
        return ReadToEnd(stdin, path, content);
    }
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
    if (file == nullptr)
        throw CommandError(ExitCode::BadInput, path, "cannot be opened for reading");
    return ReadToEnd(file.get(), path, content);
}

} // namespace

std::vector<std::byte> ReadAll(const std::string& path) {
    if (IsPipe(path))
        return ReadPipe(path, PipeContent::Any);
    FileReader reader = Require(FileReader::Open(path), ExitCode::BadInput, path);
    std::vector<std::byte> bytes(static_cast<std::size_t>(reader.Size()));
    if (!reader.Read(bytes.data(), bytes.size()))
        throw CommandError(ExitCode::BadInput, path, "file: cannot be read");
    return bytes;
}

Input::Input(const std::string& path) : name_(path) {
    if (IsPipe(path)) {
        bytes_ = ReadPipe(path, PipeContent::TextureSet);
        stream_ = std::make_unique<ReadOnlyMemoryStream>(std::span<const std::byte>(bytes_));
    } else {
        stream_ = std::make_unique<FileReader>(Require(FileReader::Open(path), ExitCode::BadInput, path));
    }
}

TextureSet LoadTextureSet(const std::string& path) {
    Input input(path);
    TextureSetMetadata metadata =
        Require(TextureSetMetadata::Load(input.GetStream()), ExitCode::BadInput, path);
    return TextureSet{std::move(input), std::move(metadata)};
}

std::vector<std::byte> ReadRange(Input& input, StreamRange range) {
    // Metadata keeps ranges inside the stream, so the size is that of bytes that exist.
    std::vector<std::byte> bytes(static_cast<std::size_t>(range.size));
    if (!input.GetStream().Seek(range.offset) || !input.GetStream().Read(bytes.data(), bytes.size()))
        throw CommandError(ExitCode::BadInput, input.GetName(),
                           "latents: cannot be read: file is shorter than before");
    return bytes;
}

std::span<const std::byte> GetWeights(const TextureSet& set, InferenceWeightType type) {
    return Require(set.metadata.GetInferenceWeights(type), ExitCode::BadInput, set.input.GetName());
}

// The names are literals, and so end in NUL.
const char* GetName(ColorSpace colorSpace) {
    return container::EnumToString(colorSpace).data();
}

const char* GetName(ChannelFormat format) {
    return container::EnumToString(format).data();
}

const char* GetName(BlockCompressedFormat format) {
    return container::EnumToString(format).data();
}

} // namespace openntc::tool
