// SPDX-License-Identifier: MIT
#include "TextureSet.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/container/Header.h"
#include "openntc/container/Schema.h"
#include "openntc/core/FileStream.h"

#include <algorithm>
#include <cinttypes>
#include <cstring>
#include <limits>
#include <memory>

namespace openntc::tool {

namespace {

// A pipe is held in memory. The largest set of 16384 x 16384 texels has less: 40 bits per texel in all mips.
constexpr std::uint64_t kLargestPipe = std::uint64_t{1} << 32;
constexpr std::uint64_t kLargestTail = std::uint64_t{1} << 20; ///< what may follow a set in a pipe

/// Reads the header, so that a pipe that never ends, or is no texture set, is not read to its end.
void BoundPipe(const std::string& path, std::span<const std::byte> beginning, InputBound& bound) {
    static constexpr char kSignature[] = {'N', 'T', 'E', 'X'};
    if (beginning.size() >= sizeof kSignature &&
        std::memcmp(beginning.data(), kSignature, sizeof kSignature) != 0)
        throw CommandError(ExitCode::BadInput, path, "header.signature: not NTEX: no texture set");
    container::HeaderBytes bytes;
    if (beginning.size() < bytes.size())
        return; // it has ended, and loading says what is missing
    std::copy_n(beginning.begin(), bytes.size(), bytes.begin());
    const container::Header header = Require(
        container::DecodeHeader(bytes, std::numeric_limits<std::uint64_t>::max()), ExitCode::BadInput, path);
    const std::uint64_t size =
        std::max(header.jsonOffset + header.jsonSize, header.binaryOffset + header.binarySize);
    if (size > kLargestPipe)
        throw CommandError(
            ExitCode::BadInput, path,
            Format("header: accounts for %" PRIu64 " bytes: a pipe may have %" PRIu64, size, kLargestPipe));
    bound.bytes = size + kLargestTail;
    bound.reason = Format(": its header accounts for %" PRIu64, size);
}

} // namespace

Input::Input(const std::string& path) : name_(path) {
    if (IsPipe(path)) {
        const auto accept = [&path](std::span<const std::byte> beginning, InputBound& bound) {
            BoundPipe(path, beginning, bound);
        };
        bytes_ = ReadAll(path, {{kLargestPipe}, accept});
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
