// SPDX-License-Identifier: MIT
// The calls that docs/migrating-from-libntc.md shows, compiled and run.
#include "support/SpecificationVectors.h"

#include "openntc/core/FileStream.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/inference/BufferPacking.h"
#include "openntc/openntc.h"
#include "openntc/texture_set/Rewrite.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>
#include <vector>

using namespace openntc;

namespace {

// The functions below stand in the page as they are.

struct Material {
    TextureSetMetadata metadata;
    NtcTextureSetConstants constants; // 624 bytes for a uniform buffer
    std::vector<std::byte> latents;   // for a storage buffer
    std::vector<std::byte> weights;   // for another one
};

Expected<Material> LoadMaterial(const std::filesystem::path& path) {
    OPENNTC_ASSIGN(FileReader file, FileReader::Open(path));
    OPENNTC_ASSIGN(TextureSetMetadata metadata, TextureSetMetadata::Load(file));
    const InferenceWeightType type = InferenceWeightType::GenericInt8;
    const int mips = metadata.GetDesc().mips;
    OPENNTC_ASSIGN(const NtcTextureSetConstants constants, MakeInferenceData(metadata, 0, mips, type));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, metadata.GetInferenceWeights(type));
    OPENNTC_ASSIGN(const std::size_t latentBytes, GetLatentBufferBytes(metadata, 0, mips));
    std::vector<std::byte> latents(latentBytes);
    OPENNTC_CHECK(ReadLatents(metadata, file, 0, mips, latents));
    return Material{std::move(metadata), constants, std::move(latents), {weights.begin(), weights.end()}};
}

Expected<std::vector<float>> DecodeOnTheCpu(const Material& material, int mip) {
    const DecodeSource source = {&material.constants, material.latents, material.weights,
                                 material.metadata.GetNetworkVersion()};
    OPENNTC_ASSIGN(const FastDecoder decoder, FastDecoder::Create(source));
    const ColorMip& size = material.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    std::vector<float> texels(16 * static_cast<std::size_t>(size.width) *
                              static_cast<std::size_t>(size.height));
    OPENNTC_CHECK(decoder.Decode(mip, {0, 0, size.width, size.height}, {.convertToLinear = true}, texels));
    return texels;
}

Expected<NtcTextureSetConstants> ShuffleChannels(Material& material) {
    std::array<ShuffleSource, NTC_MAX_CHANNELS> sources; // all undefined: not in the mask
    sources[0] = ShuffleSource::Channel(2);
    sources[1] = ShuffleSource::Constant(0.5f);
    OPENNTC_ASSIGN(const InferenceWeights shuffled,
                   ShuffleInferenceOutputs(material.metadata.GetWeights(), sources));
    const std::span<const std::byte> weights = shuffled.Get(InferenceWeightType::GenericInt8);
    material.weights.assign(weights.begin(), weights.end());
    const int mips = material.metadata.GetDesc().mips;
    return MakeInferenceData(material.metadata, 0, mips, InferenceWeightType::GenericInt8, shuffled);
}

Expected<Permutation> PickShader(const Material& material) {
    const std::string_view textures[] = {"t"};
    SceneNeeds needs;
    needs.textures = textures;
    needs.linear = true;
    needs.device.integerDotProduct = true;
    // permutation->key.ToDefines().View() is what FindShader() of openntc_add_shaders() takes.
    return MakePermutation(material.metadata, needs);
}

Expected<void> PackTwo(Material& a, Material& b, std::vector<std::byte>& buffer) {
    const PackRequest requests[] = {{a.latents.size(), a.weights.size()},
                                    {b.latents.size(), b.weights.size()}};
    PackedSet places[2];
    OPENNTC_ASSIGN(const PackingSummary summary, PlanPacking(requests, PackingLimits{}, places));
    buffer.resize(static_cast<std::size_t>(summary.largestBufferBytes));
    OPENNTC_CHECK(CopyPacked(places[0], a.latents, a.weights, buffer));
    OPENNTC_CHECK(CopyPacked(places[1], b.latents, b.weights, buffer));
    OPENNTC_CHECK(MoveConstants(a.constants, places[0].latentsOffset, places[0].weightsOffset));
    return MoveConstants(b.constants, places[1].latentsOffset, places[1].weightsOffset);
}

Expected<void> CopyFile(Stream& source, const std::filesystem::path& destination) {
    OPENNTC_ASSIGN(const TextureSetMetadata metadata, TextureSetMetadata::Load(source));
    OPENNTC_ASSIGN(WritableTextureSet copy, MakeWritableCopy(metadata, source));
    OPENNTC_ASSIGN(FileWriter file, FileWriter::Create(destination));
    OPENNTC_CHECK(copy.Write(file));
    return file.Commit();
}

} // namespace

/// Written by CopyFile and read by LoadMaterial.
Material LoadCopy(const std::vector<std::byte>& bytes) {
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "openntc_migration_test.ntc";
    ReadOnlyMemoryStream stream(bytes);
    const auto copied = CopyFile(stream, path);
    REQUIRE_MESSAGE(copied.has_value(), std::string(copied.error().GetText()));
    auto material = LoadMaterial(path);
    REQUIRE_MESSAGE(material.has_value(), std::string(material.error().GetText()));
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    return std::move(*material);
}

TEST_CASE("the calls of the migration page run") {
    Material first = LoadCopy(openntc_tests::SynthesizeV1()), other = LoadCopy(openntc_tests::SynthesizeV1());
    Material *const material = &first, *const second = &other;

    const auto texels = DecodeOnTheCpu(*material, 1);
    REQUIRE(texels);
    CHECK(texels->size() == 16 * 12 * 10);

    const auto permutation = PickShader(*material);
    REQUIRE_MESSAGE(permutation.has_value(), std::string(permutation.error().GetText()));
    CHECK(permutation->key.networkVersion == NTC_NETWORK_SMALL);

    std::vector<std::byte> buffer;
    REQUIRE(PackTwo(*material, *second, buffer));
    const DecodeSource packed = {&second->constants, buffer, buffer, NTC_NETWORK_SMALL};
    const auto decoder = FastDecoder::Create(packed);
    REQUIRE(decoder);
    std::vector<float> again(texels->size());
    REQUIRE(decoder->Decode(1, {0, 0, 12, 10}, {.convertToLinear = true}, again));
    CHECK(again == *texels);

    const auto shuffled = ShuffleChannels(*second);
    REQUIRE(shuffled);
    CHECK(shuffled->validChannelMask == 3);
    second->constants = *shuffled;
    const auto moved = DecodeOnTheCpu(*second, 1);
    REQUIRE(moved);
    CHECK((*moved)[0] == (*texels)[2]);
    CHECK((*moved)[1] == 0.5f);
}

TEST_CASE("they serve generation 3, compressed latents included") {
    SynthesisDesc synthesis;
    synthesis.desc = {37, 50, 6, 4};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(3, 12);
    Material whole = LoadCopy(openntc_tests::MakeFile(synthesis));
    synthesis.compression.latents = true;
    synthesis.compression.largestRatio = 2.0f; // noise does not get smaller
    Material compressed = LoadCopy(openntc_tests::MakeFile(synthesis));
    REQUIRE(compressed.metadata.GetLatentMips()[0].layerData[0].isCompressed);
    CHECK(compressed.latents == whole.latents);

    const auto texels = DecodeOnTheCpu(compressed, 1);
    REQUIRE(texels);
    CHECK(texels->size() == 16 * 18 * 25);
    const auto permutation = PickShader(compressed);
    REQUIRE(permutation);
    CHECK(permutation->key.networkVersion == NTC_NETWORK_GENERATION_3);

    std::vector<std::byte> buffer;
    REQUIRE(PackTwo(whole, compressed, buffer));
    const auto decoder =
        FastDecoder::Create({&compressed.constants, buffer, buffer, NTC_NETWORK_GENERATION_3});
    REQUIRE(decoder);
    std::vector<float> again(texels->size());
    REQUIRE(decoder->Decode(1, {0, 0, 18, 25}, {.convertToLinear = true}, again));
    CHECK(again == *texels);

    const auto shuffled = ShuffleChannels(whole);
    REQUIRE(shuffled);
    whole.constants = *shuffled;
    const auto moved = DecodeOnTheCpu(whole, 1);
    REQUIRE(moved);
    CHECK((*moved)[0] == (*texels)[2]);
}
