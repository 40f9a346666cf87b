// SPDX-License-Identifier: MIT
// Runs `ntc` the way a shell does, in a temporary folder of its own.
#pragma once

#include <rapidjson/document.h>
#include <rapidjson/schema.h>
#include <rapidjson/stringbuffer.h>

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <sys/wait.h>

namespace openntc_tests {

namespace fs = std::filesystem;

inline std::string ReadText(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void WriteText(const fs::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
}

class Folder {
public:
    Folder() : path_(fs::temp_directory_path() / ("openntc-cli-" + std::to_string(std::random_device()()))) {
        fs::create_directories(path_);
    }
    ~Folder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& GetPath() const { return path_; }

private:
    fs::path path_;
};

struct ProgramResult {
    int code;
    std::string output;
    std::string errors;
};

/// `arguments` go through the shell; the program runs inside `folder`, where its output lands in files. `environment`:
/// assignments before the program's name.
inline ProgramResult RunProgramWith(const Folder& folder, const std::string& environment,
                                    const std::string& arguments) {
    const std::string command =
        "cd '" + folder.GetPath().string() + "' && " + environment + " '" NTC_PROGRAM "' " + arguments;
    const fs::path logs = folder.GetPath().string() + ".logs";
    fs::create_directories(logs);
    const int status = std::system(
        ("( " + command + " ) >'" + (logs / "out").string() + "' 2>'" + (logs / "err").string() + "'")
            .c_str());
    ProgramResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadText(logs / "out"),
                         ReadText(logs / "err")};
    fs::remove_all(logs);
    return result;
}

inline ProgramResult RunProgram(const Folder& folder, const std::string& arguments) {
    return RunProgramWith(folder, "", arguments);
}

/// What a command that must succeed prints.
inline std::string RequireOutput(const Folder& folder, const std::string& arguments) {
    const ProgramResult result = RunProgram(folder, arguments);
    INFO(arguments << ": " << result.errors);
    REQUIRE(result.code == 0);
    return result.output;
}

/// What a shell starts before a program's name for the program to get one signal after so many seconds. In the foreground: timeout
/// otherwise signals its process group as well, and the second signal ends a program at once.
inline std::string SignalAfter(int seconds, const std::string& signal = "INT") {
    return "timeout --foreground --preserve-status -s " + signal + " " + std::to_string(seconds) + " ";
}

/// Whether `ntc` was built without glslang's library, which is said once.
inline bool IsShaderCompilerAbsent(const Folder& folder) {
    WriteText(folder / "probe.comp", "#version 460\nvoid main() {}\n");
    if (RunProgram(folder, "compile-shaders probe.comp --dry-run").code != 4)
        return false;
    MESSAGE("SKIP: ntc was built without glslang's library");
    return true;
}

/// Parses `text` and validates it with schemas/NAME.schema.json.
inline rapidjson::Document ParseValid(const std::string& text, const std::string& schemaName) {
    rapidjson::Document schemaText;
    schemaText.Parse(ReadText(fs::path(NTC_SCHEMA_DIR) / (schemaName + ".schema.json")).c_str());
    REQUIRE_FALSE(schemaText.HasParseError());
    const rapidjson::SchemaDocument schema(schemaText);
    rapidjson::Document document;
    document.Parse(text.c_str());
    INFO(text.substr(0, 2000));
    REQUIRE_FALSE(document.HasParseError());
    rapidjson::SchemaValidator validator(schema);
    const bool valid = document.Accept(validator);
    rapidjson::StringBuffer where;
    validator.GetInvalidDocumentPointer().StringifyUriFragment(where);
    INFO(where.GetString());
    CHECK(valid);
    return document;
}

/// An error: the code, nothing on standard output, one line on standard error that starts with "ntc: ".
inline void CheckFails(const ProgramResult& result, int code) {
    CHECK(result.code == code);
    CHECK(result.output.empty());
    CHECK(result.errors.starts_with("ntc: "));
    CHECK(result.errors.find('\n') == result.errors.size() - 1);
}

} // namespace openntc_tests
