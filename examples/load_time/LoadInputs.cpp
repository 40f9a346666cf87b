// SPDX-License-Identifier: MIT
#include "LoadInputs.h"

#include "Failure.h"
#include "InputFile.h"

#include "openntc/container/RapidJson.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace openntc::load_time {

namespace {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;

void AddFolder(const fs::path& folder, std::vector<std::string>& sets) {
    std::vector<std::string> found;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        if (entry->path().extension() == ".ntc")
            found.push_back(entry->path().string());
    }
    if (error)
        throw CommandError(ExitCode::BadInput, folder.string(), "folder: " + error.message());
    if (found.empty())
        throw CommandError(ExitCode::BadInput, folder.string(), "folder: no .ntc file in it");
    std::sort(found.begin(), found.end());
    sets.insert(sets.end(), found.begin(), found.end());
}

void AddList(const std::string& path, std::vector<std::string>& sets) {
    const std::string text = tool::ReadAllText(path);
    rapidjson::Document document;
    document.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
    const rapidjson::Document& list = document;
    if (list.HasParseError() || !list.IsObject() || !list.HasMember("files") || !list["files"].IsArray())
        throw CommandError(ExitCode::BadInput, path, "files: not a list that ntc convert-gltf writes");
    for (const auto& file : list["files"].GetArray()) {
        if (!file.IsObject() || !file.HasMember("file") || !file["file"].IsString())
            throw CommandError(ExitCode::BadInput, path, "files: an entry without a file");
        sets.push_back((fs::path(path).parent_path() / file["file"].GetString()).string());
    }
    if (list["files"].Empty())
        throw CommandError(ExitCode::BadInput, path, "files: none: at least 1");
}

} // namespace

std::vector<std::string> ListSets(const std::vector<std::string>& arguments) {
    std::vector<std::string> sets;
    if (arguments.empty())
        AddFolder(fs::path(OPENNTC_SOURCE_DIR) / "examples/materials/data", sets);
    for (const std::string& argument : arguments) {
        std::error_code ignored;
        if (fs::is_directory(argument, ignored))
            AddFolder(argument, sets);
        else if (fs::path(argument).extension() == ".json")
            AddList(argument, sets);
        else
            sets.push_back(argument);
    }
    return sets;
}

} // namespace openntc::load_time
