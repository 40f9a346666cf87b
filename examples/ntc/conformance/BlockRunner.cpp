// SPDX-License-Identifier: MIT
#include "BlockRunner.h"

#include "GuardedCase.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

using tool::Format;

std::string FormatBlock(std::span<const std::byte> block) {
    std::string text;
    for (const std::byte byte : block)
        text += Format("%02x", std::to_integer<unsigned>(byte));
    return text;
}

void CheckBlocks(const std::filesystem::path& folder, const BlockSuiteCase& blockCase, Subject& subject,
                 CaseResult& result) {
    if (!subject.GetCapabilities().blocks)
        return Finish(result, Outcome::Skip, "not supported: blocks");
    BlockRequest request = blockCase.MakeRequest({});
    const std::vector<std::byte> texels = ReadSized(folder / blockCase.texels, request.GetPictureBytes());
    const std::vector<std::byte> expected = ReadSized(folder / blockCase.blocks, request.GetBlockBytes());
    request.texels = texels;
    const std::vector<std::byte> blocks = subject.EncodeBlocks(request);
    const std::size_t unit = bc::GetBytesPerBlock(request.format), count = expected.size() / unit;
    const std::size_t columns = request.GetRowBytes() / unit;
    if (blocks.size() != expected.size())
        return Finish(result, Outcome::Fail,
                      Format("%zu bytes of blocks: expected %zu", blocks.size(), expected.size()));
    std::size_t different = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto got = std::span(blocks).subspan(i * unit, unit);
        const auto wanted = std::span(expected).subspan(i * unit, unit);
        if (std::equal(got.begin(), got.end(), wanted.begin()))
            continue;
        if (different++ == 0)
            result.suite.difference = Format("block (%zu, %zu): %s: expected %s", i % columns, i / columns,
                                             FormatBlock(got).c_str(), FormatBlock(wanted).c_str());
    }
    result.suite.texels = static_cast<std::size_t>(request.width) * static_cast<std::size_t>(request.height);
    if (different == 0)
        return Finish(result, Outcome::Pass, Format("%zu blocks; ", count) + blockCase.about);
    result.suite.cause = FindOneCause(ListBlockMistakes(), [&](BlockMistake mistake) {
        return EncodeBlockRequest(request, mistake) == blocks;
    });
    FinishDifferent(result, Format("%zu of %zu blocks differ", different, count), blockCase.about);
}

} // namespace

void RunBlockCases(const std::filesystem::path& folder, std::span<const BlockSuiteCase> cases,
                   Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add) {
    RunCaseList(cases, subject, mustPassOnly, add, [&](const BlockSuiteCase& blockCase, CaseResult& result) {
        CheckBlocks(folder, blockCase, subject, result);
    });
}

} // namespace openntc::conformance
