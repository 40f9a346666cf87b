// SPDX-License-Identifier: MIT
// The decoder's end of the adapter protocol.
#include "../Failure.h"
#include "../Output.h"
#include "Protocol.h"

#include <iostream>

namespace openntc::conformance {

namespace {

class Server {
public:
    explicit Server(Subject& subject) : subject_(subject) {}

    // One request; false for `quit`.
    bool Answer(std::string_view line) {
        const std::string_view request = TakeWord(line);
        if (request == "quit")
            return false;
        if (request == "hello") {
            const Capabilities capabilities = subject_.GetCapabilities();
            const std::string name = subject_.GetName();
            Write("ok " + FormatCapabilities(capabilities) + " " + (name.empty() ? "OpenNTC" : name) + "\n");
        } else if (request == "load") {
            line.remove_prefix(line.empty() ? 0 : 1);
            path_ = line;
            Open();
            Write("ok\n");
        } else if (request == "texels") {
            const DecodeOptions options = TakeOptions(line);
            const std::vector<tool::Texel> texels = ReadTexels(ParseNumber(TakeWord(line)).value_or(-1));
            WriteValues(subject_.DecodeTexels(texels, options));
        } else if (request == "mip") {
            const DecodeOptions options = TakeOptions(line);
            const int mip = TakeMip(line);
            const ColorMip& size = set_->metadata.GetColorMips()[static_cast<std::size_t>(mip)];
            WriteValues(subject_.DecodeMip(mip, size.width, size.height, options));
        } else if (request == "slice" || request == "slice_mips") {
            const DecodeOptions options = TakeOptions(line);
            const int mip = TakeMip(line);
            const int mips = request == "slice" ? 1 : TakeMipCount(line, mip);
            WriteValues(subject_.DecodeSlice(TakeSlice(line, mip, mips), options));
        } else if (request == "blocks") {
            WriteBlocks(line);
        } else if (request == "textures") {
            WriteTextures(line);
        } else if (request == "filter") {
            WriteTaps(line);
        } else {
            throw SubjectError(SubjectError::Kind::Failed, "request: unknown");
        }
        return true;
    }

private:
    void Open() {
        set_.reset();
        subject_.Open(path_);
        set_.emplace(tool::LoadTextureSet(path_));
    }

    static DecodeOptions TakeOptions(std::string_view& line) {
        const std::optional<DecodeMath> math = FindMath(TakeWord(line));
        if (!math)
            throw SubjectError(SubjectError::Kind::NotSupported, "maths mode");
        return {*math, TakeWord(line) == "linear"};
    }

    int TakeMip(std::string_view& line) const {
        const int mip = ParseNumber(TakeWord(line)).value_or(-1);
        if (!set_ || mip < 0 || mip >= set_->metadata.GetDesc().mips)
            throw SubjectError(SubjectError::Kind::Failed, "mip: outside the set");
        return mip;
    }

    int TakeMipCount(std::string_view& line, int firstMip) const {
        const int mips = ParseNumber(TakeWord(line)).value_or(-1);
        if (mips < 1 || mips > set_->metadata.GetDesc().mips - firstMip)
            throw SubjectError(SubjectError::Kind::Failed, "mips: outside the set");
        return mips;
    }

    SliceRequest TakeSlice(std::string_view& line, int mip, int mips) const {
        Rect slice;
        for (int* value : {&slice.left, &slice.top, &slice.width, &slice.height})
            *value = ParseNumber(TakeWord(line)).value_or(-1);
        const ColorMip& size = set_->metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        if (slice.left < 0 || slice.top < 0 || slice.width < 1 || slice.height < 1 ||
            slice.width > size.width - slice.left || slice.height > size.height - slice.top)
            throw SubjectError(SubjectError::Kind::Failed, "slice: outside the mip");
        return MakeSliceRequest(mip, mips, slice, [&](int n) -> const ColorMip& {
            return set_->metadata.GetColorMips()[static_cast<std::size_t>(n)];
        });
    }

    std::vector<tool::Texel> ReadTexels(int count) {
        if (count < 1 || count > static_cast<int>(kMaxRequestTexels))
            throw SubjectError(SubjectError::Kind::Failed, "texels: count out of range");
        std::vector<tool::Texel> texels;
        std::string line;
        bool isInside = true;
        for (int i = 0; i < count && std::getline(std::cin, line); ++i) {
            std::string_view rest = line;
            tool::Texel texel;
            texel.mip = ParseNumber(TakeWord(rest)).value_or(-1);
            const std::optional<int> x = ParseNumber(TakeWord(rest));
            const std::optional<int> y = ParseNumber(TakeWord(rest));
            texel.x = x.value_or(0);
            texel.y = y.value_or(0);
            texels.push_back(texel);
            isInside = isInside && x && y && IsInside(texel);
        }
        if (!isInside || static_cast<int>(texels.size()) != count)
            throw SubjectError(SubjectError::Kind::Failed, "texels: outside the image or too few");
        return texels;
    }

    bool IsInside(const tool::Texel& texel) const {
        if (!set_ || texel.mip < 0 || texel.mip >= set_->metadata.GetDesc().mips)
            return false;
        if (subject_.GetCapabilities().outside)
            return true;
        const ColorMip& mip = set_->metadata.GetColorMips()[static_cast<std::size_t>(texel.mip)];
        return texel.x >= 0 && texel.x < mip.width && texel.y >= 0 && texel.y < mip.height;
    }

    void WriteBlocks(std::string_view line) {
        BlockRequest request;
        const std::optional<bc::BlockFormat> format = tool::FindBlockFormat(std::string(TakeWord(line)));
        const bool hasLevel = FindBlockLevel(TakeWord(line), request.level);
        const std::optional<int> threshold = ParseNumber(TakeWord(line));
        request.width = ParseNumber(TakeWord(line)).value_or(0);
        request.height = ParseNumber(TakeWord(line)).value_or(0);
        if (request.width < 1 || request.width > kMaxBlockPicture || request.height < 1 ||
            request.height > kMaxBlockPicture)
            throw SubjectError(SubjectError::Kind::Failed, "blocks: size out of range");
        // The texels are read whatever is wrong with the rest: the next line is a request again.
        std::string row;
        std::vector<std::byte> texels;
        request.format = format.value_or(bc::BlockFormat::Bc7);
        bool isWhole = true;
        for (int y = 0; y < request.height && std::getline(std::cin, row); ++y)
            isWhole =
                ParseBytes(row, request.GetTexelBytes() * static_cast<std::size_t>(request.width), texels) &&
                isWhole;
        if (!format || !hasLevel || !threshold || *threshold < -1 || *threshold > 255)
            throw SubjectError(SubjectError::Kind::Failed, "blocks: format, level or threshold: unknown");
        if (!isWhole || texels.size() != request.GetPictureBytes())
            throw SubjectError(SubjectError::Kind::Failed,
                               "blocks: texels: not two digits a byte, or too few");
        request.alphaThreshold = *threshold;
        request.texels = texels;
        const std::vector<std::byte> blocks = subject_.EncodeBlocks(request);
        std::string text = "ok\n";
        for (std::size_t at = 0; at < blocks.size(); at += request.GetRowBytes())
            text += FormatBytes(std::span(blocks).subspan(at, request.GetRowBytes())) + "\n";
        Write(text);
    }

    static TextureOutput TakeOutput(std::string_view line, bool& isGood) {
        TextureOutput output;
        output.firstChannel = ParseNumber(TakeWord(line)).value_or(-1);
        output.channels = ParseNumber(TakeWord(line)).value_or(-1);
        isGood = FindColorSpace(TakeWord(line), output.rgb) && isGood;
        isGood = FindColorSpace(TakeWord(line), output.alpha) && isGood;
        output.bits = ParseNumber(TakeWord(line)).value_or(-1);
        return output;
    }

    void WriteTextures(std::string_view line) {
        TextureRequest request;
        const std::optional<DecodeMath> math = FindMath(TakeWord(line));
        request.math = math.value_or(DecodeMath::Int8);
        Rect& rect = request.rect;
        for (int* number :
             {&request.mip, &rect.left, &rect.top, &rect.width, &rect.height, &request.destinationLeft,
              &request.destinationTop, &request.textureWidth, &request.textureHeight})
            *number = ParseNumber(TakeWord(line)).value_or(-1);
        const int count = ParseNumber(TakeWord(line)).value_or(0);
        if (count < 1 || count > static_cast<int>(kMaxTextures))
            throw SubjectError(SubjectError::Kind::Failed, "textures: count out of range");
        // The outputs are read whatever is wrong with the rest: the next line is a request again.
        std::string row;
        bool isGood = true;
        for (int i = 0; i < count && std::getline(std::cin, row); ++i)
            request.outputs.push_back(TakeOutput(row, isGood));
        if (!math)
            throw SubjectError(SubjectError::Kind::NotSupported, "maths mode");
        if (!set_ || request.mip < 0 || request.mip >= set_->metadata.GetDesc().mips)
            throw SubjectError(SubjectError::Kind::Failed, "textures: mip: outside the set");
        const ColorMip& mip = set_->metadata.GetColorMips()[static_cast<std::size_t>(request.mip)];
        const char* problem = request.FindProblem(mip.width, mip.height);
        if (!isGood || problem != nullptr)
            throw SubjectError(SubjectError::Kind::Failed, std::string("textures: not valid: ") +
                                                               (problem != nullptr ? problem : "outputs"));
        const Textures textures = subject_.MakeTextures(request);
        std::string text = "ok\n";
        for (std::size_t n = 0; n < textures.size(); ++n) {
            const std::size_t rowBytes = request.GetRowBytes(request.outputs[n]);
            for (std::size_t at = 0; at < textures[n].size(); at += rowBytes)
                text += FormatBytes(std::span(textures[n]).subspan(at, rowBytes)) + "\n";
        }
        Write(text);
    }

    void WriteTaps(std::string_view line) {
        int count = 0;
        const std::optional<FilterRequest> request = ParseFilterRequest(line, count);
        if (count < 1 || count > kMaxFilterLookups)
            throw SubjectError(SubjectError::Kind::Failed, "filter: count out of range");
        std::vector<FilterLookup> lookups; // read whatever is wrong with the rest
        std::string row;
        bool isGood = request.has_value();
        for (int i = 0; i < count && std::getline(std::cin, row); ++i) {
            const std::optional<FilterLookup> lookup = ParseLookup(row);
            isGood = isGood && lookup;
            lookups.push_back(lookup.value_or(FilterLookup{}));
        }
        if (!isGood || static_cast<int>(lookups.size()) != count)
            throw SubjectError(SubjectError::Kind::Failed,
                               "filter: a word that is unknown or out of range, or too few lookups");
        std::string text = "ok\n";
        for (const std::vector<FilterTap>& taps : subject_.FilterLookups(*request, lookups))
            text += FormatTaps(taps) + "\n";
        Write(text);
    }

    static void Write(const std::string& text) {
        tool::WriteOutput(text);
        tool::FinishOutput();
    }

    static void WriteValues(const std::vector<Outputs>& values) {
        std::string text = "ok\n";
        for (const Outputs& outputs : values)
            text += FormatOutputs(outputs) + "\n";
        Write(text);
    }

    Subject& subject_;
    std::string path_;
    std::optional<tool::TextureSet> set_;
};

std::string MakeLine(std::string_view status, std::string_view reason) {
    return std::string(status) + " " + tool::Printable(reason) + "\n";
}

} // namespace

void ServeSubject(Subject& subject) {
    Server server(subject);
    std::string line;
    while (std::getline(std::cin, line)) {
        std::string answer;
        try {
            if (!server.Answer(line))
                return;
        } catch (const SubjectError& error) {
            answer = MakeLine(error.GetKind() == SubjectError::Kind::NotSupported ? "unsupported" : "error",
                              error.what());
        } catch (const tool::CommandError& error) {
            answer =
                MakeLine(error.GetCode() == tool::ExitCode::NoDevice ? "unsupported" : "error", error.what());
        }
        if (!answer.empty()) {
            tool::WriteOutput(answer);
            tool::FinishOutput();
        }
    }
}

} // namespace openntc::conformance
