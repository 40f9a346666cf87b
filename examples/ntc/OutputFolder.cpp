// SPDX-License-Identifier: MIT
#include "OutputFolder.h"

#include "Failure.h"
#include "Output.h"
#include "openntc/core/FileCalls.h"
#include "openntc/core/FileStream.h"

#include <cerrno>
#include <random>
#include <set>
#include <system_error>

namespace openntc::tool {

namespace fs = std::filesystem;

namespace {

// Creates `folder` and its parents; adds those that were missing to `created`, outermost first. False with the system's reason.
bool CreateFolders(const fs::path& folder, std::vector<fs::path>& created, std::error_code& error) {
    std::error_code ignored;
    if (folder.empty() || fs::is_directory(folder, ignored))
        return true;
    if (!CreateFolders(folder.parent_path(), created, error))
        return false;
    if (fs::create_directory(folder, error)) {
        created.push_back(folder);
        return true;
    }
    if (fs::is_directory(folder, ignored)) // by another process, in between
        return true;
    if (!error || error == std::errc::file_exists)
        error = std::make_error_code(std::errc::not_a_directory);
    return false;
}

} // namespace

void WriteBytes(const fs::path& path, std::span<const std::byte> bytes) {
    const std::string name = path.string();
    FileWriter file = Require(FileWriter::Create(path), ExitCode::Failed, name);
    if (!file.Write(bytes.data(), bytes.size()))
        throw CommandError(ExitCode::Failed, name,
                           Format("cannot be written: %s", SystemReason(errno).GetText()));
    Require(file.Commit(), ExitCode::Failed, name);
}

OutputFolder::OutputFolder(const fs::path& destination) : destination_(destination) {
    std::error_code error;
    bool good = CreateFolders(destination_, created_, error);
    if (good) {
        good = false;
        std::random_device device;
        for (int attempt = 0; attempt < 16 && !good; ++attempt) {
            staging_ = destination_ / (".ntc-" + std::to_string(device()) + ".tmp");
            good = fs::create_directory(staging_, error);
        }
    }
    if (!good) {
        std::error_code ignored;
        for (auto folder = created_.rbegin(); folder != created_.rend(); ++folder)
            fs::remove(*folder, ignored);
        throw CommandError(ExitCode::Failed, destination_.string(),
                           "output folder: cannot be created or written: " + error.message());
    }
}

OutputFolder::~OutputFolder() {
    std::error_code ignored;
    if (!staging_.empty())
        fs::remove_all(staging_, ignored);
    if (!committed_) {
        for (auto folder = created_.rbegin(); folder != created_.rend(); ++folder)
            fs::remove(*folder, ignored); // only if empty
    }
}

fs::path OutputFolder::Stage(const fs::path& relativeName) {
    names_.push_back(relativeName);
    return staging_ / std::to_string(names_.size());
}

std::vector<fs::path> OutputFolder::Commit() {
    // On the disk before any gets its name: a loss of power must not leave names of empty files.
    for (std::size_t i = 0; i < names_.size(); ++i)
        Require(SyncFile(staging_ / std::to_string(i + 1)), ExitCode::Failed,
                (destination_ / names_[i]).string());
    std::vector<fs::path> paths;
    std::set<fs::path> folders;
    for (std::size_t i = 0; i < names_.size(); ++i) {
        const fs::path path = destination_ / names_[i];
        std::error_code error;
        if (CreateFolders(path.parent_path(), created_, error))
            fs::rename(staging_ / std::to_string(i + 1), path, error);
        if (error)
            throw CommandError(ExitCode::Failed, path.string(),
                               "output file: cannot be put in place: " + error.message());
        folders.insert(path.parent_path());
        paths.push_back(path);
    }
    committed_ = true;
    for (const fs::path& folder : folders)
        Require(SyncFolder(folder), ExitCode::Failed, folder.string());
    return paths;
}

} // namespace openntc::tool
