// SPDX-License-Identifier: MIT
// A folder that gets all of its new files or none of them.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::tool {

/// Writes a file that has all of its bytes or does not appear. Throws CommandError(Failed).
void WriteBytes(const std::filesystem::path& path, std::span<const std::byte> bytes);
inline void WriteBytes(const std::filesystem::path& path, std::string_view text) {
    WriteBytes(path, std::as_bytes(std::span(text)));
}

/// Files are written into a staging folder inside the destination and renamed when all are complete. Without
/// Commit the staging folder disappears, and so do the destination and its parents where this object created
/// them.
class OutputFolder {
public:
    /// Throws CommandError(Failed) if the folder cannot be created.
    explicit OutputFolder(const std::filesystem::path& destination);
    ~OutputFolder();
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;

    /// Where to write the file that will become DESTINATION/`relativeName`.
    std::filesystem::path Stage(const std::filesystem::path& relativeName);

    /// Renames every staged file into place. Returns the final paths, in the order of Stage.
    std::vector<std::filesystem::path> Commit();

private:
    std::filesystem::path destination_;
    std::filesystem::path staging_;
    std::vector<std::filesystem::path> created_; // folders that did not exist, outermost first
    std::vector<std::filesystem::path> names_;
    bool committed_ = false;
};

} // namespace openntc::tool
