// SPDX-License-Identifier: MIT
#include "encode/StateFile.h"

#include "Failure.h"
#include "InputFile.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"

#include <cerrno>
#include <cstdint>
#include <cstring>

namespace openntc::tool {

namespace {

struct Header {
    char magic[8] = {'N', 'T', 'C', 'S', 'T', 'A', 'T', '4'};
    std::int32_t shape[5] = {};
    std::int32_t network = 0;
    std::uint32_t crc = 0; ///< of the bytes that follow
    std::uint32_t padding = 0;
    double fraction = 0.0;
    std::uint64_t bytes = 0;
};

} // namespace

std::string GetStatePath(const std::string& output) {
    return output + ".state";
}

EncodeState ReadState(const std::string& path) {
    std::vector<std::byte> bytes = ReadAll(path);
    Header header, expected;
    if (bytes.size() < sizeof(header))
        throw CommandError(ExitCode::BadInput, path,
                           Format("state: %zu bytes: cut: nothing to resume", bytes.size()));
    std::memcpy(&header, bytes.data(), sizeof(header));
    EncodeState state;
    bytes.erase(bytes.begin(), bytes.begin() + sizeof(header));
    state.bytes = std::move(bytes);
    if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
        header.bytes != state.bytes.size() || header.crc != Crc32(state.bytes) ||
        !(header.fraction >= 0.0 && header.fraction <= 1.0))
        throw CommandError(ExitCode::BadInput, path, "state: damaged, or not of this version");
    state.fraction = header.fraction;
    state.networkVersion = header.network;
    state.latentShape = {header.shape[0], header.shape[1], header.shape[2], header.shape[3], header.shape[4]};
    return state;
}

void WriteState(const std::string& path, const LatentShape& shape, int networkVersion, double fraction,
                std::span<const std::byte> bytes) {
    Header header;
    const int values[5] = {shape.gridSizeScale, shape.highResFeatures, shape.lowResFeatures,
                           shape.highResQuantBits, shape.lowResQuantBits};
    for (int i = 0; i < 5; ++i)
        header.shape[i] = values[i];
    header.network = networkVersion;
    header.fraction = fraction;
    header.bytes = bytes.size();
    header.crc = Crc32(bytes);
    WriteWholeFile(path, {std::as_bytes(std::span(&header, 1)), bytes});
}

void WriteWholeFile(const std::string& path, std::initializer_list<std::span<const std::byte>> parts) {
    auto file = Require(FileWriter::Create(path), ExitCode::Failed, path);
    for (const std::span<const std::byte> part : parts) {
        if (!file.Write(part.data(), part.size()))
            throw CommandError(ExitCode::Failed, path,
                               Format("cannot be written: %s", SystemReason(errno).GetText()));
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
