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

#include <algorithm>
#include <map>
#include <utility>

namespace openntc::conformance {

namespace {

namespace fs = std::filesystem;
using tool::ExitCode;

std::vector<ValueRecord> DecodeValues(const Suite::Set& set, const SuiteCase& suiteCase,
                                      std::span<const tool::Texel> texels) {
    ReadOnlyMemoryStream stream(set.bytes);
    const TextureSetMetadata metadata =
        tool::Require(TextureSetMetadata::Load(stream), ExitCode::Failed, set.file);
    const InferenceWeightType type = GetDecodeWeights(suiteCase.math) == DecodeWeights::FP8
                                         ? InferenceWeightType::GenericFP8
                                         : InferenceWeightType::GenericInt8;
    const StreamRange range = tool::Require(metadata.GetStreamRangeForLatents(0, metadata.GetDesc().mips),
                                            ExitCode::Failed, set.file);
    const NtcTextureSetConstants constants =
        tool::Require(MakeInferenceData(metadata, range, type), ExitCode::Failed, set.file);
    std::vector<std::byte> latents(set.bytes.begin() + static_cast<std::ptrdiff_t>(range.offset),
                                   set.bytes.begin() +
                                       static_cast<std::ptrdiff_t>(range.offset + range.size));
    latents.resize((latents.size() + 3) / 4 * 4); // decoders read whole words
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
    const std::string json = tool::Require(WriteExpectations(metadata), ExitCode::Failed, set.file);
    tool::WriteBytes(output.Stage(fs::path(set.file).stem().string() + ".expect.json"),
                     std::as_bytes(std::span(json)));
}

} // namespace

ExportedFiles ExportSuite(const fs::path& folder) {
    const Suite suite = MakeSuite();
    tool::OutputFolder output(folder);
    for (const Suite::Set& set : suite.sets)
        WriteSet(output, set);
    std::string mustPass;
    std::map<std::string, bool> pictures; // that are written: several cases share one
    for (std::size_t i = 0; i < suite.cases.size(); ++i) {
        tool::ThrowIfInterrupted();
        const SuiteCase& suiteCase = suite.cases[i];
        const auto set = std::find_if(suite.sets.begin(), suite.sets.end(),
                                      [&](const Suite::Set& entry) { return entry.file == suiteCase.set; });
        tool::WriteBytes(output.Stage(suiteCase.values),
                         WriteValues(DecodeValues(*set, suiteCase, suite.texels[i]), suiteCase));
        if (suiteCase.mustPass)
            mustPass += suiteCase.name + "\n";
    }
    const std::vector<BlockSuiteCase> blockCases = ListBlockSuite();
    for (const BlockSuiteCase& blockCase : blockCases) {
        tool::ThrowIfInterrupted();
        const std::vector<std::byte> texels = MakeBlockPicture(blockCase);
        if (std::exchange(pictures[blockCase.texels], true) == false)
            tool::WriteBytes(output.Stage(blockCase.texels), texels);
        tool::WriteBytes(output.Stage(blockCase.blocks), EncodeBlockRequest(blockCase.MakeRequest(texels)));
        if (blockCase.mustPass)
            mustPass += blockCase.name + "\n";
    }
    const std::string json = WriteSuite(suite.cases, blockCases);
    tool::WriteBytes(output.Stage(kSuiteFile), std::as_bytes(std::span(json)));
    tool::WriteBytes(output.Stage("mustpass.txt"), std::as_bytes(std::span(mustPass)));
    const std::string coverage = WriteCoverage(MeasureCoverage(suite));
    tool::WriteBytes(output.Stage("coverage.txt"), std::as_bytes(std::span(coverage)));
    return {suite.cases.size() + blockCases.size(), output.Commit()};
}

} // namespace openntc::conformance
