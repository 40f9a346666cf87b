// SPDX-License-Identifier: MIT
#include "encode/StateFile.h"

#include "Failure.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

namespace openntc::tool {

namespace {

struct Header {
    char magic[8] = {'N', 'T', 'C', 'S', 'T', 'A', 'T', '3'};
    std::int32_t shape[5] = {};
    std::uint32_t crc = 0; ///< of the bytes that follow
    double fraction = 0.0;
    std::uint64_t bytes = 0;
};

} // namespace

std::string GetStatePath(const std::string& output) {
    return output + ".state";
}

EncodeState ReadState(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    Header header, expected;
    if (text.size() < sizeof(header))
        throw CommandError(ExitCode::BadInput, path, "state: absent or cut: nothing to resume");
    std::memcpy(&header, text.data(), sizeof(header));
    EncodeState state;
    const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
    state.bytes.assign(bytes + sizeof(header), bytes + text.size());
    if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
        header.bytes != state.bytes.size() || header.crc != Crc32(state.bytes) ||
        !(header.fraction >= 0.0 && header.fraction <= 1.0))
        throw CommandError(ExitCode::BadInput, path, "state: damaged, or not of this version");
    state.fraction = header.fraction;
    state.latentShape = {header.shape[0], header.shape[1], header.shape[2], header.shape[3], header.shape[4]};
    return state;
}

void WriteState(const std::string& path, const EncodeState& state) {
    Header header;
    const LatentShape& shape = state.latentShape;
    const int values[5] = {shape.gridSizeScale, shape.highResFeatures, shape.lowResFeatures,
                           shape.highResQuantBits, shape.lowResQuantBits};
    for (int i = 0; i < 5; ++i)
        header.shape[i] = values[i];
    header.fraction = state.fraction;
    header.bytes = state.bytes.size();
    header.crc = Crc32(state.bytes);
    WriteWholeFile(path, {std::as_bytes(std::span(&header, 1)), state.bytes});
}

void WriteWholeFile(const std::string& path, std::initializer_list<std::span<const std::byte>> parts) {
    auto file = Require(FileWriter::Create(path), ExitCode::Failed, path);
    for (const std::span<const std::byte> part : parts) {
        if (!file.Write(part.data(), part.size()))
            throw CommandError(ExitCode::Failed, path, "file: cannot be written: disk full?");
    }
    Require(file.Commit(), ExitCode::Failed, path);
}

void CheckWritable(const std::string& path) {
    std::error_code error;
    const auto kind = std::filesystem::status(path, error).type();
    if (kind != std::filesystem::file_type::not_found && kind != std::filesystem::file_type::regular)
        throw CommandError(ExitCode::Failed, path, "file: exists and is not a regular file");
    Require(FileWriter::Create(path), ExitCode::Failed, path);
}

} // namespace openntc::tool
