// SPDX-License-Identifier: MIT
// `ntc conformance export`: write the project's vectors.
#include "Failure.h"
#include "Interrupt.h"
#include "OutputFolder.h"
#include "TextureSet.h"
#include "conformance/HardwareIntervals.h"
#include "conformance/Suite.h"
#include "conformance/SuiteCoverage.h"
#include "conformance/VectorFiles.h"

#include "openntc/core/Stream.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/ReadLatents.h"

#include <algorithm>
#include <map>
#include <utility>

namespace openntc::conformance {

namespace {

namespace fs = std::filesystem;
using tool::ExitCode;

const Suite::Set& FindSet(const Suite& suite, const std::string& file) {
    return *std::find_if(suite.sets.begin(), suite.sets.end(),
                         [&](const Suite::Set& entry) { return entry.file == file; });
}

std::vector<ValueRecord> DecodeValues(const Suite::Set& set, const SuiteCase& suiteCase,
                                      std::span<const tool::Texel> texels) {
    ReadOnlyMemoryStream stream(set.bytes);
    const TextureSetMetadata metadata =
        tool::Require(TextureSetMetadata::Load(stream), ExitCode::Failed, set.file);
    const InferenceWeightType type = GetDecodeWeights(suiteCase.math) == DecodeWeights::FP8
                                         ? InferenceWeightType::GenericFP8
                                         : InferenceWeightType::GenericInt8;
    const int mips = metadata.GetDesc().mips;
    const NtcTextureSetConstants constants =
        tool::Require(MakeInferenceData(metadata, 0, mips, type), ExitCode::Failed, set.file);
    std::vector<std::byte> latents(
        tool::Require(GetLatentBufferBytes(metadata, 0, mips), ExitCode::Failed, set.file));
    tool::Require(ReadLatents(metadata, stream, 0, mips, latents), ExitCode::Failed, set.file);
    const DecodeSource source{&constants, latents,
                              tool::Require(metadata.GetInferenceWeights(type), ExitCode::Failed, set.file),
                              metadata.GetNetworkVersion(), GetDecodeWeights(suiteCase.math)};
    std::vector<ValueRecord> records;
    for (const tool::Texel& texel : texels) {
        ValueRecord record;
        record.texel = texel;
        tool::Require(DecodeReference(source, texel.mip, {texel.x, texel.y, 1, 1},
                                      {suiteCase.math, suiteCase.linear}, record.outputs),
                      ExitCode::Failed, set.file);
        records.push_back(record);
    }
    if (suiteCase.interval)
        FillHardwareIntervals(source, records);
    return records;
}

void WriteSet(tool::OutputFolder& output, const Suite::Set& set) {
    tool::WriteBytes(output.Stage(set.file), set.bytes);
    ReadOnlyMemoryStream stream(set.bytes);
    const TextureSetMetadata metadata =
        tool::Require(TextureSetMetadata::Load(stream), ExitCode::Failed, set.file);
    if (metadata.GetGeneration() > 1)
        return; // ranges and constants to expect are those of generation 1
    const std::string json = tool::Require(WriteExpectations(metadata), ExitCode::Failed, set.file);
    tool::WriteBytes(output.Stage(fs::path(set.file).stem().string() + ".expect.json"),
                     std::as_bytes(std::span(json)));
}

void WriteBlocks(tool::OutputFolder& output, std::span<const BlockSuiteCase> cases) {
    std::map<std::string, bool> pictures; // that are written: several cases share one
    for (const BlockSuiteCase& blockCase : cases) {
        tool::ThrowIfInterrupted();
        const std::vector<std::byte> texels = MakeBlockPicture(blockCase);
        if (std::exchange(pictures[blockCase.texels], true) == false)
            tool::WriteBytes(output.Stage(blockCase.texels), texels);
        tool::WriteBytes(output.Stage(blockCase.blocks), EncodeBlockRequest(blockCase.MakeRequest(texels)));
    }
}

void WriteTextures(tool::OutputFolder& output, const Suite& suite, std::span<const TextureSuiteCase> cases) {
    for (const TextureSuiteCase& textureCase : cases) {
        const TextureRequest& request = textureCase.request;
        const Suite::Set& set = FindSet(suite, textureCase.set);
        SuiteCase decoding;
        decoding.math = request.math;
        std::vector<tool::Texel> texels;
        for (int i = 0; i < request.rect.width * request.rect.height; ++i)
            texels.push_back({request.mip, request.rect.left + i % request.rect.width,
                              request.rect.top + i / request.rect.width});
        std::vector<Outputs> stored;
        for (const ValueRecord& record : DecodeValues(set, decoding, texels))
            stored.push_back(record.outputs);
        ReadOnlyMemoryStream stream(set.bytes);
        const TextureSetMetadata metadata =
            tool::Require(TextureSetMetadata::Load(stream), ExitCode::Failed, set.file);
        const TextureRange range = MakeTextureRange(metadata, request, stored);
        std::vector<std::byte> bytes;
        for (std::size_t n = 0; n < request.outputs.size(); ++n) {
            bytes.insert(bytes.end(), range.least[n].begin(), range.least[n].end());
            bytes.insert(bytes.end(), range.greatest[n].begin(), range.greatest[n].end());
        }
        tool::WriteBytes(output.Stage(textureCase.values), bytes);
    }
}

void WriteLookups(tool::OutputFolder& output, std::span<const FilterSuiteCase> cases) {
    for (const FilterSuiteCase& filterCase : cases) {
        FilterFile file{MakeFilterLookups(filterCase), {}};
        file.taps = RunFilter(filterCase.request, file.lookups);
        tool::WriteBytes(output.Stage(filterCase.lookups), WriteFilterFile(file));
    }
}

template <typename Case>
void ListMustPass(std::span<const Case> cases, std::string& text) {
    for (const Case& one : cases)
        text += one.mustPass ? one.name + "\n" : "";
}

} // namespace

ExportedFiles ExportSuite(const fs::path& folder) {
    const Suite suite = MakeSuite();
    tool::OutputFolder output(folder);
    for (const Suite::Set& set : suite.sets)
        WriteSet(output, set);
    for (std::size_t i = 0; i < suite.cases.size(); ++i) {
        tool::ThrowIfInterrupted();
        const SuiteCase& suiteCase = suite.cases[i];
        tool::WriteBytes(
            output.Stage(suiteCase.values),
            WriteValues(DecodeValues(FindSet(suite, suiteCase.set), suiteCase, suite.texels[i]), suiteCase));
    }
    const SuiteParts parts{ListBlockSuite(), ListTextureSuite(), ListFilterSuite()};
    WriteBlocks(output, parts.blocks);
    WriteTextures(output, suite, parts.textures);
    WriteLookups(output, parts.filtering);
    std::string mustPass;
    ListMustPass<SuiteCase>(suite.cases, mustPass);
    ListMustPass<BlockSuiteCase>(parts.blocks, mustPass);
    ListMustPass<TextureSuiteCase>(parts.textures, mustPass);
    ListMustPass<FilterSuiteCase>(parts.filtering, mustPass);
    const std::string json = WriteSuite(suite.cases, parts);
    tool::WriteBytes(output.Stage(kSuiteFile), std::as_bytes(std::span(json)));
    tool::WriteBytes(output.Stage("mustpass.txt"), std::as_bytes(std::span(mustPass)));
    const std::string coverage = WriteCoverage(MeasureCoverage(suite));
    tool::WriteBytes(output.Stage("coverage.txt"), std::as_bytes(std::span(coverage)));
    return {suite.cases.size() + parts.blocks.size() + parts.textures.size() + parts.filtering.size(),
            output.Commit()};
}

} // namespace openntc::conformance
