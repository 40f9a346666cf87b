// SPDX-License-Identifier: MIT
// What a file may look like: order of views and chunks, absent members, the form of LibNTC 0.5.
#include "RawFile.h"
#include "SuiteBuilder.h"

#include <cstring>
#include <numeric>

namespace openntc::conformance {

namespace {

using rapidjson::Value;

RawFile MakeRawFile(std::uint32_t seed, bool withFP8 = false) {
    SynthesisDesc synthesis = Describe(seed, 24, 20, 4, kPlainShape);
    synthesis.withFP8 = withFP8;
    return RawFile(SynthesizeBytes(synthesis));
}

void AddLayouts(SuiteBuilder& builder) {
    RawFile file = MakeRawFile(800);
    RawLayout layout;
    layout.order.resize(file.views.size());
    std::iota(layout.order.begin(), layout.order.end(), std::size_t{0});
    layout.gap = 12;
    builder.AddSet("views-gaps", file.Write(layout));
    builder.AddMistakeCase({Mistake::SequentialViews}, DecodeMath::Int8, "gaps between views");

    std::vector<std::size_t> indices(file.views.size());
    for (std::size_t i = 0; i < indices.size(); ++i)
        indices[i] = (5 * i + 3) % indices.size(); // 14 views
    file.RenumberViews(indices);
    std::rotate(layout.order.begin(), layout.order.begin() + 6, layout.order.end());
    layout.gap = 0;
    builder.AddSet("views-shuffled", file.Write(layout));
    builder.AddMistakeCase({Mistake::FixedViews}, DecodeMath::Int8,
                           "views in another order, by index and in the file");

    file = MakeRawFile(801);
    layout = {};
    layout.dataFirst = true;
    builder.AddSet("chunk-order", file.Write(layout));
    builder.AddMistakeCase({Mistake::BinaryBehindJson}, DecodeMath::Int8, "the JSON chunk behind the data");
    layout.dataFirst = false;
    layout.chunkGap = 256;
    builder.AddSet("chunk-gap", file.Write(layout));
    builder.AddCase("chunk-gap", DecodeMath::Int8, builder.ListAllTexels(23), "a gap between the chunks");

    // Views that nobody reads, views longer than what is in them.
    file = MakeRawFile(802);
    file.views.emplace_back(40, std::byte{0x5A});
    for (std::vector<std::byte>& view : file.views)
        view.resize(view.size() + 8, std::byte{0xC3});
    builder.AddSet("views-long", file.Write());
    builder.AddCase("views-long", DecodeMath::Int8, builder.ListAllTexels(23),
                    "views that are longer than their content, and one that nothing refers to");

    file = MakeRawFile(803);
    file.DisguiseText();
    layout = {};
    layout.isPretty = true;
    layout.hasNul = false;
    builder.AddSet("json-form", file.Write(layout));
    builder.AddCase("json-form", DecodeMath::Int8, builder.ListAllTexels(23),
                    "JSON with members in another order, unknown ones, other cases, spaces, and no NUL");
}

void AddMembers(SuiteBuilder& builder) {
    // Everything optional is absent: types on the network, scales of one, positions that are computed.
    RawFile file = MakeRawFile(810);
    Value& mlp = file.json["mlp"];
    file.Set(mlp, "weightType", "Int8");
    mlp.RemoveMember("activation");
    for (std::size_t i = 0; i < 4; ++i)
        file.GetLayer(i).RemoveMember("weightType");
    Value& last = file.GetLayer(3);
    file.views[last["scaleView"].GetUint()].assign(4, std::byte{});
    last.RemoveMember("scaleView");
    unsigned number = 0;
    for (Value& mip : file.json["colorMips"].GetArray()) {
        mip.RemoveMember("width");
        mip.RemoveMember("height");
        // One of the two alone counts for nothing.
        mip.RemoveMember(number++ % 2 == 0 ? "positionScale" : "positionLod");
    }
    file.json.RemoveMember("channels");
    file.json.RemoveMember("textures");
    builder.AddSet("absent-members", file.Write());
    builder.AddMistakeCase({Mistake::AbsentScalesZero, Mistake::AbsentPositionsZero}, DecodeMath::Int8,
                           "a file without optional members");

    // An object in place of an array of one; a network in the list and none in `mlp`.
    SynthesisDesc synthesis = Describe(811, 12, 10, 1, kPlainShape);
    RawFile single{SynthesizeBytes(synthesis)};
    Value network(single.json["mlp"], single.json.GetAllocator());
    single.json.RemoveMember("mlp");
    single.json.RemoveMember("numColorMips");
    single.Set(single.json, "mlpVersions", Value(rapidjson::kArrayType));
    single.json["mlpVersions"].PushBack(network, single.json.GetAllocator());
    for (const char* key : {"mlpVersions", "textures", "latents", "colorMips"}) {
        Value element(single.json[key][0], single.json.GetAllocator());
        single.Set(single.json, key, std::move(element));
    }
    builder.AddSet("single-objects", single.Write());
    builder.AddCase("single-objects", DecodeMath::Int8, builder.ListAllTexels(7),
                    "objects in place of arrays of one, no `mlp`, no numColorMips");

    RawFile exchanged = MakeRawFile(812, true);
    Value int8(exchanged.json["mlp"], exchanged.json.GetAllocator());
    Value fp8(exchanged.json["mlpVersions"][0], exchanged.json.GetAllocator());
    exchanged.json["mlp"] = fp8;
    exchanged.json["mlpVersions"][0] = int8;
    builder.AddSet("networks-exchanged", exchanged.Write());
    builder.AddMistakeCase({Mistake::FirstNetworkIsInt8}, DecodeMath::Int8,
                           "the FP8 network in `mlp`, the Int8 one in `mlpVersions`");
    builder.AddCase("networks-exchanged-fp8", DecodeMath::FP8, builder.ListAllTexels(23),
                    "the FP8 network in `mlp`, the Int8 one in `mlpVersions`");

    // Records of textures with every format; a decoder of texels has no use for them.
    RawFile records = MakeRawFile(813);
    Value textures(rapidjson::kArrayType);
    auto& allocator = records.json.GetAllocator();
    static constexpr const char* kFormats[] = {"UNKNOWN", "UNORM8",  "UNORM16",
                                               "FLOAT16", "FLOAT32", "UINT32"};
    static constexpr const char* kSpaces[] = {"Linear", "sRGB", "HLG"};
    static constexpr const char* kBlocks[] = {"None", "BC1", "BC2", "BC3", "BC4", "BC5", "BC6", "BC7"};
    for (unsigned i = 0; i < 8; ++i) {
        Value texture(rapidjson::kObjectType);
        texture.AddMember("name",
                          Value(i == 0   ? ""
                                : i == 1 ? "\xC3\xA4/\\ \"1\""
                                         : "t",
                                allocator),
                          allocator);
        texture.AddMember("firstChannel", 2 * i, allocator);
        texture.AddMember("numChannels", i == 0 ? 16u : i % 2 + 1, allocator);
        texture.AddMember("channelFormat", Value(kFormats[i % 6], allocator), allocator);
        texture.AddMember("rgbColorSpace", Value(kSpaces[i % 3], allocator), allocator);
        texture.AddMember("alphaColorSpace", Value(kSpaces[(i + 1) % 3], allocator), allocator);
        texture.AddMember("bcFormat", Value(kBlocks[i], allocator), allocator);
        texture.AddMember("bcQuality", i * 36, allocator);
        textures.PushBack(texture, allocator);
    }
    records.json["textures"] = textures;
    builder.AddSet("texture-records", records.Write());
    builder.AddCase("texture-records", DecodeMath::Int8, builder.ListAllTexels(23),
                    "textures of every format, overlapping; channels of texels do not depend on them");
}

void StoreFloats(std::vector<std::byte>& view, const std::vector<float>& values) {
    view.resize(4 * values.size());
    std::memcpy(view.data(), values.data(), view.size());
}

// Biases of a layer as LibNTC 0.5 wrote them: bias * scale in binary32, moved off the integer.
void MakeLegacy(RawFile& file, Value& layer, std::size_t index) {
    std::vector<std::byte>& scaleView = file.views[layer["scaleView"].GetUint()];
    std::vector<std::byte>& biasView = file.views[layer["biasView"].GetUint()];
    std::vector<float> scales(scaleView.size() / 4);
    std::vector<std::int32_t> integers(scales.size());
    std::memcpy(scales.data(), scaleView.data(), scaleView.size());
    std::memcpy(integers.data(), biasView.data(), biasView.size());
    std::vector<float> biases;
    for (std::size_t row = 0; row < scales.size(); ++row) {
        if (row % 4 == 0) // ties: quotients of powers of two and halves are exact
            scales[row] = index == 3 ? 0.25f : 0x1p-15f;
        const float offset = row % 4 == 0 ? 0.5f : row % 4 == 1 ? 0.75f : row % 4 == 2 ? -0.375f : 0.0f;
        float bias = (static_cast<float>(integers[row]) + offset) * scales[row];
        if (row % 8 == 7) {
            scales[row] = row % 16 == 7 ? 0.0f : -0.0f;
            bias = (row % 3 == 0 ? -1.0f : 1.0f) * (0.3f + static_cast<float>(row) / 7);
        }
        biases.push_back(bias);
    }
    StoreFloats(scaleView, scales);
    StoreFloats(biasView, biases);
}

void AddLegacy(SuiteBuilder& builder) {
    RawFile file = MakeRawFile(820, true);
    const auto strip = [](Value& layer, std::initializer_list<const char*> keys) {
        for (const char* key : keys)
            layer.RemoveMember(key);
    };
    for (std::size_t i = 0; i < 4; ++i) {
        Value& layer = file.GetLayer(i);
        MakeLegacy(file, layer, i);
        strip(layer, {"weightType", "scaleType", "biasType"});
    }
    file.Set(file.json["mlp"], "weightType", "Int8");
    file.Set(file.json["mlp"], "scaleBiasType", "Float32");
    for (Value& channel : file.json["channels"].GetArray()) {
        file.Set(channel, "scale", Value(0.75));
        file.Set(channel, "bias", Value(-0.25));
    }
    builder.AddSet("legacy-network", file.Write());
    builder.AddMistakeCase({Mistake::LegacyTypeOfNetwork, Mistake::LegacyTruncatedBias,
                            Mistake::LegacyZeroScale, Mistake::LegacyChannelScale},
                           DecodeMath::Int8,
                           "a file of LibNTC 0.5: binary32 biases, types on the network, scales of zero",
                           false, 10);

    file = MakeRawFile(821, true);
    for (std::size_t i = 0; i < 4; ++i) {
        Value& layer = file.GetLayer(i);
        MakeLegacy(file, layer, i);
        strip(layer, {"scaleType", "biasType"});
        file.Set(layer, "scaleBiasType", "Float32");
    }
    Value& fp8 = file.json["mlpVersions"][0]["layers"][3];
    MakeLegacy(file, fp8, 3);
    file.Set(fp8, "biasType", "Float32");
    builder.AddSet("legacy-layer", file.Write());
    builder.AddMistakeCase({Mistake::LegacyTypeOfLayer, Mistake::LegacyTiesToEven}, DecodeMath::Int8,
                           "a file of LibNTC 0.5: binary32 biases, types on the layers");
    builder.AddCase("legacy-fp8", DecodeMath::FP8, builder.ListAllTexels(23),
                    "binary32 biases of the last layer of an FP8 network");

    file = MakeRawFile(822);
    for (std::size_t i = 0; i < 4; ++i) {
        MakeLegacy(file, file.GetLayer(i), i);
        file.Set(file.GetLayer(i), "biasType", "Float32");
    }
    builder.AddSet("legacy-bias-type", file.Write());
    builder.AddMistakeCase({Mistake::LegacyBiasBits}, DecodeMath::Int8,
                           "binary32 biases beside the other types of later files");
}

} // namespace

void AddFileForms(SuiteBuilder& builder) {
    AddLayouts(builder);
    AddMembers(builder);
    AddLegacy(builder);
}

} // namespace openntc::conformance
