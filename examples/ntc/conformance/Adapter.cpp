// SPDX-License-Identifier: MIT
// The suite's end of the adapter protocol.
#include "../Failure.h"
#include "../Output.h"
#include "ChildProcess.h"
#include "Protocol.h"

#include <algorithm>
#include <filesystem>

namespace openntc::conformance {

namespace {

// An adapter that hangs would cost its timeout in every case.
constexpr int kMaxTimeouts = 2;

class AdapterSubject final : public Subject {
public:
    explicit AdapterSubject(const AdapterOptions& options) : options_(options) { Start(); }

    std::string GetName() const override { return name_; }
    Arithmetic GetArithmetic() const override { return Arithmetic::Vulkan; } // may be any device

    // What is known needs no running program.
    Capabilities GetCapabilities() override {
        if (!isKnown_)
            RequireRunning();
        return capabilities_;
    }

    void Open(const std::string& path) override {
        const std::string absolute = std::filesystem::absolute(path).string();
        if (absolute.find('\n') != std::string::npos)
            throw SubjectError(SubjectError::Kind::Failed, "adapter: the path holds a line feed");
        RequireRunning();
        process_.Send("load " + absolute + "\n");
        ReadStatus();
    }

    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                      const DecodeOptions& options) override {
        std::vector<Outputs> values;
        while (values.size() < texels.size()) {
            const auto part =
                texels.subspan(values.size(), std::min(kMaxRequestTexels, texels.size() - values.size()));
            std::string request = tool::Format("texels %s %s %zu\n", tool::GetName(options.math),
                                               options.convertToLinear ? "linear" : "stored", part.size());
            for (const tool::Texel& texel : part)
                request += tool::Format("%d %d %d\n", texel.mip, texel.x, texel.y);
            process_.Send(request);
            ReadStatus();
            ReadOutputs(part.size(), values);
        }
        return values;
    }

    std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options) override {
        if (!capabilities_.wholeMips)
            return Subject::DecodeMip(mip, width, height, options);
        return Ask(tool::Format("mip %s %s %d\n", tool::GetName(options.math),
                                options.convertToLinear ? "linear" : "stored", mip),
                   static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    }

    std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
        const std::size_t mips = slice.parts.size();
        if (mips == 1 ? !capabilities_.slices : !capabilities_.sliceMips)
            return Subject::DecodeSlice(slice, options);
        const std::string numbers =
            (mips == 1 ? tool::Format("%d", slice.firstMip) : tool::Format("%d %zu", slice.firstMip, mips)) +
            tool::Format(" %d %d %d %d", slice.rect.left, slice.rect.top, slice.rect.width,
                         slice.rect.height);
        return Ask(tool::Format("%s %s %s %s\n", mips == 1 ? "slice" : "slice_mips",
                                tool::GetName(options.math), options.convertToLinear ? "linear" : "stored",
                                numbers.c_str()),
                   slice.CountTexels());
    }

    std::vector<std::byte> EncodeBlocks(const BlockRequest& request) override {
        RequireRunning();
        std::string text =
            tool::Format("blocks %s %s %d %d %d\n", bc::BlockFormatToString(request.format),
                         tool::GetName(request.level), request.alphaThreshold, request.width, request.height);
        const std::size_t row = request.GetTexelBytes() * static_cast<std::size_t>(request.width);
        for (std::size_t at = 0; at < request.texels.size(); at += row)
            text += FormatBytes(request.texels.subspan(at, row)) + "\n";
        process_.Send(text);
        ReadStatus();
        std::vector<std::byte> blocks;
        while (blocks.size() < request.GetBlockBytes()) {
            const std::string line = ReadLine();
            if (!ParseBytes(line, request.GetRowBytes(), blocks))
                FailGarbage(line, "the bytes of a row of blocks, two hexadecimal digits each");
        }
        return blocks;
    }

    Textures MakeTextures(const TextureRequest& request) override {
        RequireRunning();
        const Rect& rect = request.rect;
        std::string text = tool::Format(
            "textures %s %d %d %d %d %d %d %d %d %d %zu\n", tool::GetName(request.math), request.mip,
            rect.left, rect.top, rect.width, rect.height, request.destinationLeft, request.destinationTop,
            request.textureWidth, request.textureHeight, request.outputs.size());
        for (const TextureOutput& output : request.outputs)
            text += tool::Format("%d %d %s %s %d\n", output.firstChannel, output.channels,
                                 GetColorSpaceWord(output.rgb), GetColorSpaceWord(output.alpha), output.bits);
        process_.Send(text);
        ReadStatus();
        Textures textures;
        for (const TextureOutput& output : request.outputs) {
            std::vector<std::byte>& bytes = textures.emplace_back();
            while (bytes.size() < request.GetTextureBytes(output)) {
                const std::string line = ReadLine();
                if (!ParseBytes(line, request.GetRowBytes(output), bytes))
                    FailGarbage(line, "the bytes of a row of texels, two hexadecimal digits each");
            }
        }
        return textures;
    }

    FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups) override {
        RequireRunning();
        process_.Send(FormatFilterRequest(request, lookups));
        ReadStatus();
        FilterTaps taps;
        for (std::size_t i = 0; i < lookups.size(); ++i) {
            const std::string line = ReadLine();
            if (!ParseTaps(line, taps.emplace_back()))
                FailGarbage(line, "taps of five words each");
        }
        return taps;
    }

    bool Restart() override {
        process_.End();
        return timeouts_ < kMaxTimeouts;
    }

    std::string WaitForUnasked(double seconds) override {
        if (!process_.IsRunning())
            return {};
        const Expected<std::string> line = process_.ReadLine(GetDeadline(seconds), seconds);
        if (line)
            return MakeUnasked(*line);
        const std::string text = line.error().GetText();
        return text.starts_with("no answer") ? std::string() : text;
    }

    std::string Finish() override {
        if (!process_.IsRunning())
            return {};
        process_.Send("quit\n");
        const Expected<std::string> line = process_.ReadLine(GetDeadline(1), 1);
        process_.End();
        if (line)
            return MakeUnasked(*line);
        const std::string text = line.error().GetText(); // an exit code is nobody's business
        return text.starts_with("ended by signal") ? text : std::string();
    }

private:
    static ChildProcess::Clock::time_point GetDeadline(double seconds) {
        return ChildProcess::Clock::now() + std::chrono::milliseconds(static_cast<long long>(seconds * 1000));
    }

    static std::string MakeUnasked(const std::string& line) {
        return "a line that was not asked for: \"" + tool::Printable(std::string_view(line).substr(0, 60)) +
               "\"";
    }

    std::vector<Outputs> Ask(const std::string& request, std::size_t count) {
        process_.Send(request);
        ReadStatus();
        std::vector<Outputs> values;
        ReadOutputs(count, values);
        return values;
    }

    [[noreturn]] void FailCase(const std::string& text,
                               SubjectError::Kind kind = SubjectError::Kind::Broken) {
        process_.End();
        throw SubjectError(kind, "adapter: " + text);
    }

    [[noreturn]] void FailGarbage(const std::string& line, const char* expected) {
        const std::string shown = tool::Printable(std::string_view(line).substr(0, 60));
        FailCase("garbage: \"" + shown + "\" instead of " + expected);
    }

    void Start() {
        const auto started = process_.Start(options_.command);
        if (!started)
            throw tool::CommandError(tool::ExitCode::BadInput, options_.command.front(),
                                     std::string("adapter: ") + started.error().GetText());
        isGreeted_ = false;
    }

    void RequireRunning() {
        if (timeouts_ >= kMaxTimeouts)
            throw SubjectError(SubjectError::Kind::NotRun,
                               tool::Format("not run: the adapter did not answer %d times", kMaxTimeouts));
        if (!process_.IsRunning())
            Start();
        if (isGreeted_)
            return;
        process_.Send(tool::Format("hello %d\n", kProtocolVersion));
        const std::string answer = ReadStatus();
        isGreeted_ = true;
        std::string_view rest = answer;
        capabilities_ = ParseCapabilities(TakeWord(rest));
        isKnown_ = true;
        rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
        name_ = tool::Printable(rest.substr(0, 200));
    }

    std::string ReadLine() {
        // One deadline an answer, however many lines it has.
        Expected<std::string> line = process_.ReadLine(deadline_, options_.timeoutSeconds);
        if (!line) {
            const std::string text = line.error().GetText();
            const bool isTimeout = text.starts_with("no answer");
            timeouts_ += isTimeout ? 1 : 0;
            FailCase(text, isTimeout ? SubjectError::Kind::Hung : SubjectError::Kind::Broken);
        }
        return std::move(*line);
    }

    // The first line of an answer, without its `ok`.
    std::string ReadStatus() {
        deadline_ = GetDeadline(options_.timeoutSeconds);
        const std::string line = ReadLine();
        std::string_view rest = line;
        const std::string_view word = TakeWord(rest);
        if (word == "ok")
            return std::string(rest);
        const std::string reason =
            tool::Printable(rest.substr(std::min(rest.find_first_not_of(' '), rest.size())));
        if (word == "unsupported")
            throw SubjectError(SubjectError::Kind::NotSupported, "not supported: " + reason);
        if (word == "error") // it is still in step with us
            throw SubjectError(SubjectError::Kind::Failed, "adapter: error: " + reason);
        FailGarbage(line, "`ok`, `unsupported REASON` or `error REASON`");
    }

    void ReadOutputs(std::size_t count, std::vector<Outputs>& values) {
        for (std::size_t i = 0; i < count; ++i) {
            const std::string line = ReadLine();
            const std::optional<Outputs> outputs = ParseOutputs(line);
            if (!outputs)
                FailGarbage(line, "16 words of 8 hexadecimal digits");
            values.push_back(*outputs);
        }
    }

    AdapterOptions options_;
    ChildProcess process_;
    ChildProcess::Clock::time_point deadline_;
    std::string name_;
    Capabilities capabilities_;
    bool isGreeted_ = false;
    bool isKnown_ = false; // name and capabilities
    int timeouts_ = 0;
};

} // namespace

std::unique_ptr<Subject> MakeAdapterSubject(const AdapterOptions& options) {
    return std::make_unique<AdapterSubject>(options);
}

} // namespace openntc::conformance
