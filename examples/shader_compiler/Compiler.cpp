// SPDX-License-Identifier: MIT
#include "shader_compiler/Compiler.h"

#include "shader_compiler/Failure.h"
#include "shader_compiler/Includer.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <spirv-tools/libspirv.hpp>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>

namespace openntc::shader_compiler {

namespace {

struct Environment {
    const char* name;
    glslang::EShTargetClientVersion client;
    glslang::EShTargetLanguageVersion language;
    spv_target_env validator;
};

constexpr std::array kEnvironments = {
    Environment{"vulkan1.0", glslang::EShTargetVulkan_1_0, glslang::EShTargetSpv_1_0, SPV_ENV_VULKAN_1_0},
    Environment{"vulkan1.1", glslang::EShTargetVulkan_1_1, glslang::EShTargetSpv_1_3, SPV_ENV_VULKAN_1_1},
    Environment{"vulkan1.2", glslang::EShTargetVulkan_1_2, glslang::EShTargetSpv_1_5, SPV_ENV_VULKAN_1_2},
    Environment{"vulkan1.3", glslang::EShTargetVulkan_1_3, glslang::EShTargetSpv_1_6, SPV_ENV_VULKAN_1_3},
};

const Environment* FindEnvironment(const std::string& name) {
    for (const Environment& environment : kEnvironments) {
        if (name == environment.name)
            return &environment;
    }
    return nullptr;
}

const Environment& GetEnvironment(const std::string& name) {
    const Environment* environment = FindEnvironment(name);
    if (environment == nullptr)
        throw Failure(FailureKind::Usage, "--target-env",
                      name + ": vulkan1.0, vulkan1.1, vulkan1.2 or vulkan1.3");
    return *environment;
}

EShLanguage GetLanguage(Stage stage) {
    return stage == Stage::Compute    ? EShLangCompute
           : stage == Stage::Fragment ? EShLangFragment
                                      : EShLangVertex;
}

// The first "ERROR: …" of a log, or its first line; without the word.
std::string GetFirstError(const std::string& log) {
    constexpr std::string_view kError = "ERROR: ";
    std::size_t begin = log.find(kError);
    begin = begin == std::string::npos ? log.find_first_not_of('\n') : begin + kError.size();
    if (begin == std::string::npos)
        return "no message of the compiler";
    std::string line = log.substr(begin, log.find('\n', begin) - begin);
    line.resize(line.find_last_not_of(" \r\t") + 1);
    return line;
}

std::string MakePreamble(const Permutation& permutation) {
    std::string preamble = permutation.hlsl ? "#define NTC_HLSL 1\n" : "";
    for (std::string define : permutation.defines) {
        define[define.find('=')] = ' ';
        preamble += "#define " + define + "\n";
    }
    return preamble;
}

// The steps and settings of `glslangValidator -V`, so that its SPIR-V is the same, byte for byte.
CompileResult CompileText(const std::string& text, const Permutation& permutation,
                          const CompileSettings& settings, const Environment& environment) {
    const EShLanguage language = GetLanguage(permutation.stage);
    const std::string name = permutation.path.string();
    const std::string preamble = MakePreamble(permutation);
    const char* const texts[] = {text.data()};
    const int lengths[] = {static_cast<int>(text.size())};
    const char* const names[] = {name.c_str()};
    auto messages = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    if (permutation.hlsl)
        messages = static_cast<EShMessages>(messages | EShMsgReadHlsl);

    CompileResult result;
    glslang::TShader shader(language);
    shader.setStringsWithLengthsAndNames(texts, lengths, names, 1);
    if (permutation.hlsl)
        shader.setEntryPoint(permutation.entry.c_str());
    shader.setPreamble(preamble.c_str());
    shader.setEnvInput(permutation.hlsl ? glslang::EShSourceHlsl : glslang::EShSourceGlsl, language,
                       glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, environment.client);
    shader.setEnvTarget(glslang::EShTargetSpv, environment.language);
    Includer includer(permutation.path, settings.includeDirectories);
    if (!shader.parse(GetDefaultResources(), 100, false, messages, includer)) {
        result.error = GetFirstError(shader.getInfoLog());
        return result;
    }
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages) || !program.mapIO()) {
        result.error = GetFirstError(program.getInfoLog());
        return result;
    }
    glslang::SpvOptions options;
    options.disableOptimizer = false;
    spv::SpvBuildLogger logger;
    glslang::GlslangToSpv(*program.getIntermediate(language), result.words, &logger, &options);
    if (result.words.empty())
        result.error = GetFirstError(logger.getAllMessages());
    return result;
}

void StartGlslang() {
    static std::once_flag once;
    std::call_once(once, [] { glslang::InitializeProcess(); });
}

// A shader of nothing but a cooperative vector.
const CompileResult& GetCooperativeVectorProbe() {
    static const CompileResult probe = [] {
        StartGlslang();
        Permutation permutation;
        permutation.path = "cooperative vectors";
        return CompileText(
            "#version 460\n#extension GL_NV_cooperative_vector : require\nlayout(local_size_x = 1) in;\n"
            "void main() { coopvecNV<float, 4> v = coopvecNV<float, 4>(1.0); }\n",
            permutation, {}, GetEnvironment("vulkan1.3"));
    }();
    return probe;
}

bool CanValidateCooperativeVectors() {
    static const bool can = Validate(GetCooperativeVectorProbe().words, "vulkan1.3").empty();
    return can;
}

} // namespace

bool IsTargetEnvironment(const std::string& name) {
    return FindEnvironment(name) != nullptr;
}

bool KnowsCooperativeVectors() {
    return GetCooperativeVectorProbe().IsGood();
}

std::string Validate(std::span<const std::uint32_t> words, const std::string& targetEnvironment) {
    std::string message;
    spvtools::SpirvTools tools(GetEnvironment(targetEnvironment).validator);
    tools.SetMessageConsumer(
        [&](spv_message_level_t, const char*, const spv_position_t& at, const char* text) {
            if (message.empty())
                message = "SPIR-V word " + std::to_string(at.index) + ": " +
                          std::string(text, std::strcspn(text, "\n"));
        });
    if (tools.Validate(words.data(), words.size()))
        return {};
    return message.empty() ? "SPIR-V: refused by the validator" : message;
}

CompileResult Compile(const Permutation& permutation, const CompileSettings& settings) {
    StartGlslang();
    const auto begin = std::chrono::steady_clock::now();
    const bool coopVec = permutation.NeedsCooperativeVectors();
    // Cooperative vectors are an extension of Vulkan 1.3.
    const std::string name = coopVec ? "vulkan1.3" : settings.targetEnvironment;
    std::ifstream stream(permutation.path, std::ios::binary);
    std::error_code ignored;
    if (!stream || std::filesystem::is_directory(permutation.path, ignored))
        throw Failure(FailureKind::Input, permutation.path.string(), "file: cannot be read");
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    CompileResult result = CompileText(text, permutation, settings, GetEnvironment(name));
    if (result.IsGood() && settings.validate && (!coopVec || CanValidateCooperativeVectors()))
        result.error = Validate(result.words, name);
    result.milliseconds =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

std::vector<CompileResult> CompileAll(const std::vector<Permutation>& permutations,
                                      const CompileSettings& settings, int threads,
                                      const std::function<bool()>& progress) {
    std::vector<CompileResult> results(permutations.size());
    std::vector<std::exception_ptr> thrown(permutations.size());
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    // Permutations are begun in their order, so whatever stops the work, all before the first bad one are done.
    const auto work = [&] {
        while (!stop) {
            const std::size_t i = next++;
            if (i >= permutations.size())
                return;
            try {
                results[i] = Compile(permutations[i], settings);
                stop = stop || !results[i].IsGood();
            } catch (...) {
                thrown[i] = std::current_exception();
                stop = true;
            }
            const std::lock_guard lock(mutex);
            if (progress && !progress())
                stop = true;
        }
    };
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t count =
        std::min(permutations.size(), threads > 0 ? static_cast<std::size_t>(threads) : cores);
    std::vector<std::thread> workers;
    for (std::size_t i = 1; i < count; ++i)
        workers.emplace_back(work);
    work();
    for (std::thread& worker : workers)
        worker.join();
    for (std::size_t i = 0; i < results.size(); ++i) {
        if (thrown[i])
            std::rethrow_exception(thrown[i]);
        if (!results[i].IsGood()) {
            const std::string defines = permutations[i].GetDefines();
            throw Failure(FailureKind::Input, permutations[i].path.string(),
                          (defines.empty() ? "" : defines + ": ") + results[i].error);
        }
    }
    return results;
}

} // namespace openntc::shader_compiler
