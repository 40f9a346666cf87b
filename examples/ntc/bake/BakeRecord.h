// SPDX-License-Identifier: MIT
// What a bake remembers of a material that it finished: DIR/.bake/NAME.json.
#pragma once

#include "bake/SourceHashes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

struct BakeSource {
    std::string path; ///< absolute
    SourceHash hash;

    bool operator==(const BakeSource&) const = default;
};

struct BakeRecord {
    std::string name;     ///< of the material
    std::string root;     ///< absolute path of the input under which it was found
    std::string origin;   ///< absolute path of its manifest, model or folder
    std::string key;      ///< MakeContentKey
    std::string settings; ///< MakeSettingsKey
    std::string kernel;   ///< that made it
    std::string missed;   ///< the goal that the file misses, `psnr: 31.20 dB: …`; empty: none
    FileStamp output;
    std::uint32_t crc = 0;
    double psnr = 0.0, bitsPerPixel = 0.0;
    std::uint64_t steps = 0;
    std::vector<BakeSource> sources; ///< images
};

/// DIR/.bake, and inside it.
std::string GetBakeFolder(const std::string& folder);
std::string GetRecordPath(const std::string& folder, const std::string& name);

/// The record at `path`, whose paths are relative to `folder`. nullopt: there is none that can be read, for whatever
/// reason; its material is then made again.
std::optional<BakeRecord> ReadRecord(const std::string& path, const std::string& folder);

/// Throws CommandError(Failed).
void WriteRecord(const BakeRecord& record, const std::string& folder);

/// All that lie under `folder`/.bake.
std::vector<BakeRecord> ReadRecords(const std::string& folder);

} // namespace openntc::tool
