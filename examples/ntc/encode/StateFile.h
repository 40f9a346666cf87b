// SPDX-License-Identifier: MIT
// What an interrupted encoding leaves beside its output, for --resume.
#pragma once

#include "openntc/format/NetworkDescription.h"
#include "openntc/texture_set/LatentShape.h"

#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct EncodeState {
    LatentShape latentShape{};
    int networkVersion = NTC_NETWORK_UNKNOWN;
    double fraction = 0.0; ///< of the schedule
    std::vector<std::byte> bytes;
};

/// OUTPUT.state.
std::string GetStatePath(const std::string& output);

/// Throws CommandError(BadInput).
EncodeState ReadState(const std::string& path);

/// Replaces the state as a whole or not at all. Throws CommandError(Failed).
void WriteState(const std::string& path, const LatentShape& shape, int networkVersion, double fraction,
                std::span<const std::byte> bytes);

/// Writes a whole file or nothing. Throws CommandError(Failed).
void WriteWholeFile(const std::string& path, std::initializer_list<std::span<const std::byte>> parts);

/// Throws CommandError(Failed) if a file cannot be written there: before minutes of work, not after.
void CheckWritable(const std::string& path);

} // namespace openntc::tool
