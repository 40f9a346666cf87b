// SPDX-License-Identifier: MIT
#include "shader_compiler/Compiler.h"

#include "shader_compiler/Failure.h"
#include "shader_compiler/Flatten.h"
#include "shader_compiler/Includer.h"
#include "shader_compiler/Processes.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/SPIRV/GlslangToSpv.h>
#include <spirv-tools/libspirv.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <exception>
#include <mutex>
#include <optional>
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
    std::string preamble =
        permutation.hlsl ? "#define NTC_HLSL 1\n" : "#extension GL_GOOGLE_include_directive : require\n";
    for (std::string define : permutation.defines) {
        define[define.find('=')] = ' ';
        preamble += "#define " + define + "\n";
    }
    return preamble;
}

// The step of `glslangValidator -E`: no client, so of the macros that depend on it none is defined.
CompileResult PreprocessText(const std::string& text, const Permutation& permutation,
                             const CompileSettings& settings) {
    const std::string name = permutation.path.string();
    const std::string preamble = MakePreamble(permutation);
    const char* const texts[] = {text.data()};
    const int lengths[] = {static_cast<int>(text.size())};
    const char* const names[] = {name.c_str()};
    auto messages = EShMsgOnlyPreprocessor;
    if (permutation.hlsl)
        messages = static_cast<EShMessages>(messages | EShMsgReadHlsl);
    // The text is the same for every stage; this one exists in every version.
    glslang::TShader shader(EShLangFragment);
    shader.setStringsWithLengthsAndNames(texts, lengths, names, 1);
    shader.setPreamble(preamble.c_str());
    Includer includer(permutation.path, settings.includeDirectories);
    CompileResult result;
    std::string preprocessed;
    // 460: of a text of functions, which the host's file gives its version.
    if (!shader.preprocess(GetDefaultResources(), 460, ECoreProfile, false, false, messages, &preprocessed,
                           includer)) {
        result.error = GetFirstError(shader.getInfoLog());
        return result;
    }
    const std::string defines = permutation.GetDefines();
    result.text = FlattenText(preprocessed, permutation.source + (defines.empty() ? "" : " ") + defines +
                                                ", flattened; OpenNTC's functions in it: MIT license");
    return result;
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
    // Textures that a shader writes have the format of the view, as in D3D; glslang would say Rgba32f.
    shader.setNoStorageFormat(permutation.hlsl);
    shader.setPreamble(preamble.c_str());
    shader.setEnvInput(permutation.hlsl ? glslang::EShSourceHlsl : glslang::EShSourceGlsl, language,
                       glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, environment.client);
    // glslang 12 crashes on a function with a ByteAddressBuffer parameter when it writes SPIR-V later than 1.3, which is all
    // that its HLSL needs.
    shader.setEnvTarget(glslang::EShTargetSpv, permutation.hlsl
                                                   ? std::min(environment.language, glslang::EShTargetSpv_1_3)
                                                   : environment.language);
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

// What a child process answers: this, two texts and the words. Of a result they are its error and text and the kind is 0; of a
// Failure the texts are its own and the kind is 1 more than its number.
struct Packed {
    double milliseconds = 0;
    std::uint32_t kind = 0;
    std::uint32_t sizes[2] = {0, 0};
};

std::string Pack(const Packed& head, const std::string& first, const std::string& second,
                 std::span<const std::uint32_t> words) {
    std::string bytes(sizeof(head), '\0');
    std::memcpy(bytes.data(), &head, sizeof(head));
    bytes += first;
    bytes += second;
    const auto code = std::as_bytes(words);
    bytes.append(reinterpret_cast<const char*>(code.data()), code.size());
    return bytes;
}

std::string PackResult(const CompileResult& result) {
    return Pack(
        {result.milliseconds,
         0,
         {static_cast<std::uint32_t>(result.error.size()), static_cast<std::uint32_t>(result.text.size())}},
        result.error, result.text, result.words);
}

std::string PackFailure(const Failure& failure) {
    const std::string text = failure.what();
    return Pack(
        {0,
         static_cast<std::uint32_t>(failure.GetKind()) + 1,
         {static_cast<std::uint32_t>(failure.GetSubject().size()), static_cast<std::uint32_t>(text.size())}},
        failure.GetSubject(), text, {});
}

std::optional<Failure> Unpack(const std::string& bytes, CompileResult& result) {
    Packed head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    const std::string first = bytes.substr(sizeof(head), head.sizes[0]);
    const std::string second = bytes.substr(sizeof(head) + head.sizes[0], head.sizes[1]);
    if (head.kind != 0)
        return Failure(static_cast<FailureKind>(head.kind - 1), first, second);
    result.milliseconds = head.milliseconds;
    result.error = first;
    result.text = second;
    const std::size_t at = sizeof(head) + head.sizes[0] + head.sizes[1];
    result.words.resize((bytes.size() - at) / 4);
    // After an error there are none, and memcpy takes no null pointer even for nothing.
    if (!result.words.empty())
        std::memcpy(result.words.data(), bytes.data() + at, 4 * result.words.size());
    return std::nullopt;
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
    if (const std::string reason = WhyUnreadable(permutation.path, stream); !reason.empty())
        throw Failure(FailureKind::Input, permutation.path.string(), "file: cannot be read: " + reason);
    const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    CompileResult result = settings.flatten ? PreprocessText(text, permutation, settings)
                                            : CompileText(text, permutation, settings, GetEnvironment(name));
    if (result.IsGood() && !settings.flatten && settings.validate &&
        (!coopVec || CanValidateCooperativeVectors()))
        result.error = Validate(result.words, name);
    result.milliseconds =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

std::vector<CompileResult> CompileAll(const std::vector<Permutation>& permutations,
                                      const CompileSettings& settings, int processes,
                                      const std::function<bool()>& progress) {
    StartGlslang(); // once, and not in every child
    std::vector<CompileResult> results(permutations.size());
    std::vector<std::optional<Failure>> failures(permutations.size());
    const auto work = [&](std::size_t i) {
        try {
            return PackResult(Compile(permutations[i], settings));
        } catch (const Failure& failure) {
            return PackFailure(failure);
        } catch (const std::exception& exception) {
            return PackFailure(Failure(FailureKind::Input, permutations[i].path.string(), exception.what()));
        }
    };
    // Permutations are begun in their order, so whatever stops the work, all before the first bad one are done.
    const auto done = [&](std::size_t i, const Answer& answer) {
        const std::string defines = permutations[i].GetDefines();
        if (answer.crash.empty())
            failures[i] = Unpack(answer.bytes, results[i]);
        else
            results[i].error = "the compiler crashed: " + answer.crash;
        if (!results[i].IsGood())
            failures[i] = Failure(FailureKind::Input, permutations[i].path.string(),
                                  (defines.empty() ? "" : defines + ": ") + results[i].error);
        const bool goOn = !progress || progress();
        return goOn && !failures[i];
    };
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    RunInProcesses(permutations.size(), processes > 0 ? static_cast<std::size_t>(processes) : cores, work,
                   done);
    for (const std::optional<Failure>& failure : failures) {
        if (failure)
            throw *failure;
    }
    return results;
}

} // namespace openntc::shader_compiler
