// SPDX-License-Identifier: MIT
#include "TextureSuite.h"

#include "../Json.h"
#include "Protocol.h"
#include "SuiteEntry.h"

#include <iterator>

namespace openntc::conformance {

namespace {

constexpr const char* kSpaces[] = {"linear", "srgb", "hlg"}; // in the order of ColorSpace

bool IsSpanInside(int start, int size, int whole) {
    return start >= 0 && size >= 1 && size <= whole && start <= whole - size;
}

TextureOutput ReadTextureOutput(SuiteEntry& entry) {
    TextureOutput output;
    output.firstChannel = entry.TakeNumber("firstChannel", 0, 15);
    output.channels = entry.TakeNumber("channels", 1, 4);
    output.bits = entry.TakeNumber("bits", 0, 16);
    if (!FindColorSpace(entry.TakeText("rgb"), output.rgb))
        entry.Refuse("rgb");
    if (!FindColorSpace(entry.TakeText("alpha"), output.alpha))
        entry.Refuse("alpha");
    return output;
}

TextureSuiteCase ReadTextureCase(SuiteEntry& entry) {
    TextureSuiteCase textureCase;
    TextureRequest& request = textureCase.request;
    textureCase.name = entry.TakeText("name");
    textureCase.set = entry.TakeFileName("set");
    textureCase.values = entry.TakeFileName("values");
    textureCase.about = entry.TakeText("about");
    textureCase.mustPass = entry.TakeFlag("mustPass");
    const std::optional<DecodeMath> math = FindMath(entry.TakeText("math"));
    if (!math)
        entry.Refuse("math");
    request.math = math.value_or(DecodeMath::Int8);
    request.mip = entry.TakeNumber("mip", 0, NTC_MAX_MIPS - 1);
    const std::vector<int> rect = entry.TakeNumbers("rect", 4, 0, kMaxTextureSide);
    request.rect = {rect[0], rect[1], rect[2], rect[3]};
    const std::vector<int> destination = entry.TakeNumbers("destination", 2, 0, kMaxTextureSide);
    request.destinationLeft = destination[0];
    request.destinationTop = destination[1];
    const std::vector<int> size = entry.TakeNumbers("size", 2, 1, kMaxTextureSide);
    request.textureWidth = size[0];
    request.textureHeight = size[1];
    if (const rapidjson::Value* outputs = entry.FindObjects("outputs")) {
        for (const rapidjson::Value& value : outputs->GetArray()) {
            SuiteEntry one(value);
            request.outputs.push_back(ReadTextureOutput(one));
            if (one.GetProblem() != nullptr)
                entry.Refuse(one.GetProblem());
        }
    }
    if (entry.GetProblem() == nullptr && request.FindProblem(kMaxTextureSide, kMaxTextureSide) != nullptr)
        entry.Refuse(request.FindProblem(kMaxTextureSide, kMaxTextureSide));
    return textureCase;
}

void WriteNumbers(tool::JsonWriter& json, const char* key, std::initializer_list<int> numbers) {
    json.Key(key);
    json.BeginArray();
    for (const int number : numbers)
        json.Value(number);
    json.EndArray();
}

TextureOutput MakeTextureOutput(int firstChannel, int channels, int bits = 8,
                                ColorSpace rgb = ColorSpace::Linear, ColorSpace alpha = ColorSpace::Linear) {
    return {firstChannel, channels, rgb, alpha, bits};
}

/// Cases of whole mips, or of a rectangle at a place of its own.
class TextureLister {
public:
    void Add(const std::string& name, const std::string& set, const TextureRequest& request,
             const std::string& about) {
        cases_.push_back(
            {"textures-" + name, set + ".ntc", "textures-" + name + ".textures", request, true, about});
    }
    std::vector<TextureSuiteCase> Take() { return std::move(cases_); }

private:
    std::vector<TextureSuiteCase> cases_;
};

TextureRequest MakeTextureRequest(const Rect& rect, int mip, std::vector<TextureOutput> outputs) {
    TextureRequest request;
    request.mip = mip;
    request.rect = rect;
    request.textureWidth = rect.width;
    request.textureHeight = rect.height;
    request.outputs = std::move(outputs);
    return request;
}

} // namespace

const char* GetColorSpaceWord(ColorSpace space) {
    return kSpaces[static_cast<std::size_t>(space)];
}

bool FindColorSpace(std::string_view word, ColorSpace& space) {
    for (std::size_t i = 0; i < std::size(kSpaces); ++i) {
        if (word == kSpaces[i]) {
            space = static_cast<ColorSpace>(i);
            return true;
        }
    }
    return false;
}

const char* TextureRequest::FindProblem(int mipWidth, int mipHeight) const {
    if (!IsSpanInside(rect.left, rect.width, mipWidth) || !IsSpanInside(rect.top, rect.height, mipHeight))
        return "rect";
    if (textureWidth < 1 || textureWidth > kMaxTextureSide || textureHeight < 1 ||
        textureHeight > kMaxTextureSide)
        return "size";
    if (!IsSpanInside(destinationLeft, rect.width, textureWidth) ||
        !IsSpanInside(destinationTop, rect.height, textureHeight))
        return "destination";
    if (outputs.empty() || outputs.size() > kMaxTextures)
        return "outputs";
    for (const TextureOutput& output : outputs) {
        if (output.firstChannel < 0 || output.channels < 1 || output.channels > 4 ||
            output.firstChannel > 16 - output.channels)
            return "channels";
        if (output.bits != 0 && output.bits != 8 && output.bits != 16)
            return "bits";
    }
    return nullptr;
}

Expected<std::vector<TextureSuiteCase>> ReadTextureCases(std::span<const std::byte> json) {
    return ReadCaseList<TextureSuiteCase>(json, "textures", ReadTextureCase);
}

void WriteTextureCases(tool::JsonWriter& json, std::span<const TextureSuiteCase> cases) {
    json.Key("textures");
    json.BeginArray();
    for (const TextureSuiteCase& textureCase : cases) {
        const TextureRequest& request = textureCase.request;
        json.BeginObject();
        json.Member("name", std::string_view(textureCase.name));
        json.Member("set", std::string_view(textureCase.set));
        json.Member("values", std::string_view(textureCase.values));
        json.Member("math", tool::GetName(request.math));
        json.Member("mip", request.mip);
        WriteNumbers(json, "rect",
                     {request.rect.left, request.rect.top, request.rect.width, request.rect.height});
        WriteNumbers(json, "destination", {request.destinationLeft, request.destinationTop});
        WriteNumbers(json, "size", {request.textureWidth, request.textureHeight});
        json.Key("outputs");
        json.BeginArray();
        for (const TextureOutput& output : request.outputs) {
            json.BeginObject();
            json.Member("firstChannel", output.firstChannel);
            json.Member("channels", output.channels);
            json.Member("rgb", GetColorSpaceWord(output.rgb));
            json.Member("alpha", GetColorSpaceWord(output.alpha));
            json.Member("bits", output.bits);
            json.EndObject();
        }
        json.EndArray();
        json.Member("mustPass", textureCase.mustPass);
        json.Member("about", std::string_view(textureCase.about));
        json.EndObject();
    }
    json.EndArray();
}

std::vector<TextureSuiteCase> ListTextureSuite() {
    TextureLister list;
    list.Add("codes", "plain",
             MakeTextureRequest({0, 0, 9, 7}, 0, {MakeTextureOutput(0, 4), MakeTextureOutput(5, 3)}),
             "the nearest of 256 codes; below 0 and above 1");
    list.Add("codes-16", "plain", MakeTextureRequest({3, 1, 5, 5}, 0, {MakeTextureOutput(2, 4, 16)}),
             "the nearest of 65536 codes");
    list.Add("floats", "plain", MakeTextureRequest({2, 4, 5, 4}, 0, {MakeTextureOutput(8, 4, 0)}),
             "binary32: the outputs as they are");
    TextureRequest half =
        MakeTextureRequest({0, 0, 4, 4}, 1, {MakeTextureOutput(4, 4, 0), MakeTextureOutput(0, 4)});
    half.math = DecodeMath::Int8Half;
    list.Add("half", "plain", half, "outputs of int8_half");
    TextureRequest placed =
        MakeTextureRequest({5, 3, 7, 5}, 0, {MakeTextureOutput(1, 4), MakeTextureOutput(9, 2)});
    placed.destinationLeft = 2;
    placed.destinationTop = 4;
    placed.textureWidth = 12;
    placed.textureHeight = 11;
    list.Add("placed", "plain", placed, "an odd rectangle at another place; nothing else is written");
    std::vector<TextureOutput> sixteen;
    for (int channel = 0; channel < 16; ++channel)
        sixteen.push_back(MakeTextureOutput(channel, 1));
    list.Add("sixteen", "plain", MakeTextureRequest({4, 2, 3, 2}, 0, sixteen),
             "a texture for each channel, 15 too");
    list.Add(
        "last-channels", "plain",
        MakeTextureRequest({1, 1, 4, 3}, 0,
                           {MakeTextureOutput(12, 4), MakeTextureOutput(13, 3), MakeTextureOutput(14, 2)}),
        "outputs that end with channel 15; components that a texture lacks");
    list.Add("mip", "plain",
             MakeTextureRequest({1, 0, 4, 3}, 1, {MakeTextureOutput(0, 4), MakeTextureOutput(7, 1, 16)}),
             "a rectangle of mip 1");
    // Channel c of colours-1 is stored in space (c + 1) % 3, of colours-2 in (c + 2) % 3.
    using enum ColorSpace;
    list.Add("to-linear", "colours-1",
             MakeTextureRequest({0, 0, 8, 6}, 0, {MakeTextureOutput(0, 3), MakeTextureOutput(3, 4, 16)}),
             "sRGB, HLG and linear side by side, to linear");
    list.Add("to-srgb", "colours-2",
             MakeTextureRequest(
                 {4, 3, 8, 6}, 0,
                 {MakeTextureOutput(0, 4, 8, sRGB, Linear), MakeTextureOutput(6, 4, 16, sRGB, sRGB)}),
             "to sRGB, alpha to linear or to sRGB");
    list.Add("to-hlg", "colours-1",
             MakeTextureRequest({2, 2, 6, 6}, 0, {MakeTextureOutput(2, 4, 16, HLG, HLG)}),
             "to HLG, from all three");
    list.Add("kept", "colours-1",
             MakeTextureRequest({1, 1, 6, 5}, 0,
                                {MakeTextureOutput(0, 1, 8, sRGB), MakeTextureOutput(1, 1, 8, HLG),
                                 MakeTextureOutput(4, 1, 0, HLG)}),
             "channels of the colour space that is asked for stay as they are");
    list.Add("floats-to-linear", "colours-2",
             MakeTextureRequest({0, 0, 5, 4}, 1, {MakeTextureOutput(0, 4, 0)}),
             "binary32, to linear within the promises of Vulkan");
    return list.Take();
}

} // namespace openntc::conformance
