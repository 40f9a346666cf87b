// SPDX-License-Identifier: MIT
#include "GlslangProgram.h"

#include "Failure.h"
#include "InputFile.h"
#include "conformance/ChildProcess.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

namespace openntc::tool {

namespace fs = std::filesystem;

namespace {

/// A file that is gone afterwards.
class ScratchFile {
public:
    explicit ScratchFile(const char* ending)
        : path_(fs::temp_directory_path() / ("ntc-" + std::to_string(std::random_device()()) + ending)) {}
    ~ScratchFile() {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;

    const fs::path& GetPath() const { return path_; }

private:
    fs::path path_;
};

} // namespace

std::vector<std::uint32_t> RunGlslang(const GlslangRequest& request) {
    const ScratchFile output(".spv");
    std::vector<std::string> command = {request.program, "--quiet", "-V", "--target-env",
                                        request.targetEnvironment};
    for (const fs::path& folder : request.includeDirectories)
        command.push_back("-I" + folder.string());
    for (const std::string& define : request.defines)
        command.push_back("-D" + define);
    command.insert(command.end(), {"-o", output.GetPath().string(), request.source.string()});
    conformance::ChildProcess process;
    constexpr double kSeconds = 60;
    const auto deadline = conformance::ChildProcess::Clock::now() + std::chrono::seconds(60);
    std::string lines;
    if (Expected<void> started = process.Start(command); !started)
        throw CommandError(ExitCode::BadInput, request.program, started.error().GetText());
    Expected<std::string> line = process.ReadLine(deadline, kSeconds);
    for (; line; line = process.ReadLine(deadline, kSeconds)) {
        if (!line->empty())
            lines += (lines.empty() ? "" : "; ") + *line;
    }
    std::error_code ignored;
    if (!fs::exists(output.GetPath(), ignored))
        throw CommandError(ExitCode::BadInput, request.program,
                           lines.empty() ? line.error().GetText() : lines);
    const std::vector<std::byte> bytes = ReadAll(output.GetPath().string());
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

std::string WhyNoCooperativeVectors(const std::string& program) {
    const ScratchFile probe(".comp");
    std::ofstream(probe.GetPath()) << "#version 460\n#extension GL_NV_cooperative_vector : require\n"
                                      "layout(local_size_x = 1) in;\n"
                                      "void main() { coopvecNV<float, 4> v = coopvecNV<float, 4>(1.0); }\n";
    try {
        RunGlslang({program, probe.GetPath(), {}, {}, "vulkan1.3"});
        return {};
    } catch (const CommandError& error) {
        const std::string text = error.what();
        return text.substr(0, text.find(';'));
    }
}

std::string FindCooperativeVectorGlslang() {
    const char* const named = std::getenv("OPENNTC_GLSLANG");
    for (const std::string& program : {std::string(named != nullptr ? named : ""), std::string("glslang"),
                                       std::string("glslangValidator")}) {
        if (!program.empty() && WhyNoCooperativeVectors(program).empty())
            return program;
    }
    return {};
}

} // namespace openntc::tool
