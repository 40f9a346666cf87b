// SPDX-License-Identifier: MIT
#include "bake/BakeFiles.h"

#include "Failure.h"
#include "InputFile.h"
#include "bake/BakeRecord.h"
#include "encode/StateFile.h"
#include "gltf/MaterialList.h"

#include <string_view>
#include <vector>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

bool IsHex(std::string_view text) {
    return !text.empty() && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

/// `NAME.12ab.tmp`: what a writer that was killed leaves.
bool IsLeftover(std::string_view file, std::string_view name) {
    constexpr std::string_view kEnd = ".tmp";
    return file.size() > name.size() + 1 + kEnd.size() && file.starts_with(name) &&
           file[name.size()] == '.' && file.ends_with(kEnd) &&
           IsHex(file.substr(name.size() + 1, file.size() - name.size() - 1 - kEnd.size()));
}

/// `STEM.0123456789abcdef.state`, also half written.
bool IsState(std::string_view file, std::string_view stem) {
    constexpr std::size_t kKey = 16;
    constexpr std::string_view kEnd = ".state";
    if (file.size() < stem.size() + 1 + kKey + kEnd.size() || !file.starts_with(stem) ||
        file[stem.size()] != '.' || !IsHex(file.substr(stem.size() + 1, kKey)) ||
        file.substr(stem.size() + 1 + kKey, kEnd.size()) != kEnd)
        return false;
    const std::string_view state = file.substr(0, stem.size() + 1 + kKey + kEnd.size());
    return file == state || IsLeftover(file, state);
}

template <typename Predicate>
void RemoveFiles(const fs::path& folder, const Predicate& isUnwanted) {
    std::error_code error;
    std::vector<fs::path> unwanted;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (isUnwanted(entry.path().filename().string()))
            unwanted.push_back(entry.path());
    }
    for (const fs::path& path : unwanted)
        fs::remove(path, error);
}

/// `folder` and those round it, up to `last`, which stays.
void RemoveEmptyFolders(fs::path folder, const fs::path& last) {
    std::error_code error;
    while (folder != last && fs::is_empty(folder, error) && !error) {
        fs::remove(folder, error);
        folder = folder.parent_path();
    }
}

} // namespace

void MakeFolderOf(const fs::path& file) {
    std::error_code error;
    if (file.has_parent_path())
        fs::create_directories(file.parent_path(), error);
    if (error)
        throw CommandError(ExitCode::Failed, file.parent_path().string(),
                           "folder: cannot be made: " + error.message());
}

std::string GetBakeStatePath(const std::string& folder, const std::string& name, const std::string& key) {
    return (fs::path(GetBakeFolder(folder)) / (name + "." + key + ".state")).string();
}

void RemoveLeftovers(const std::string& folder, const std::string& name, const std::string& key) {
    const fs::path output = fs::path(folder) / (name + ".ntc"), record = GetRecordPath(folder, name);
    const std::string state = fs::path(GetBakeStatePath(folder, name, key)).filename().string();
    RemoveFiles(output.parent_path(),
                [&](const std::string& file) { return IsLeftover(file, output.filename().string()); });
    RemoveFiles(record.parent_path(), [&](const std::string& file) {
        return file != state &&
               (IsState(file, record.stem().string()) || IsLeftover(file, record.filename().string()));
    });
}

void RemoveMaterial(const std::string& folder, const std::string& name) {
    const fs::path output = fs::path(folder) / (name + ".ntc"), record = GetRecordPath(folder, name);
    RemoveLeftovers(folder, name, {});
    std::error_code ignored;
    fs::remove(output, ignored);
    fs::remove(record, ignored);
    // The list of a model goes with its last file.
    const fs::path list = output.parent_path() / kMaterialListName;
    if (std::distance(fs::directory_iterator(output.parent_path(), ignored), {}) == 1 &&
        fs::is_regular_file(list, ignored))
        fs::remove(list, ignored);
    RemoveEmptyFolders(output.parent_path(), folder);
    RemoveEmptyFolders(record.parent_path(), GetBakeFolder(folder));
}

void WriteIfDifferent(const std::string& path, const std::string& text) {
    std::error_code error;
    if (!fs::is_regular_file(path, error) || ReadAllText(path) != text)
        WriteWholeFile(path, {std::as_bytes(std::span(text))});
}

} // namespace openntc::tool
