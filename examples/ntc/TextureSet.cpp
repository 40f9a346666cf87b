// SPDX-License-Identifier: MIT
#include "TextureSet.h"

#include "Failure.h"

#include "openntc/container/Schema.h"
#include "openntc/core/FileStream.h"

#include <cstring>
#include <memory>

namespace openntc::tool {

namespace {

constexpr std::uint64_t kLargestPipe = std::uint64_t{1}
                                       << 36; // the largest set of 16384 x 16384 texels has less

} // namespace

Input::Input(const std::string& path) : name_(path) {
    if (IsPipe(path)) {
        // An endless pipe that is no texture set must not be read to its end.
        const auto checkSignature = [&path](std::span<const std::byte> beginning) {
            static constexpr char kSignature[] = {'N', 'T', 'E', 'X'};
            if (beginning.size() >= sizeof kSignature &&
                std::memcmp(beginning.data(), kSignature, sizeof kSignature) != 0)
                throw CommandError(ExitCode::BadInput, path, "header.signature: not NTEX: no texture set");
        };
        bytes_ = ReadAll(path, {kLargestPipe, checkSignature});
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
