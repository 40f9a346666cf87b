// SPDX-License-Identifier: MIT
#include "BlockRunner.h"

#include "GuardedCase.h"

#include "../InputFile.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

using tool::Format;

/// The one mistake that gives these blocks, or nothing.
std::string FindBlockCause(const BlockRequest& request, const std::vector<std::byte>& blocks) {
    std::string cause;
    for (const BlockMistakeInfo& info : ListBlockMistakes()) {
        if (EncodeBlockRequest(request, info.mistake) != blocks)
            continue;
        if (!cause.empty())
            return {};
        cause = info.cause;
    }
    return cause;
}

std::string FormatBlock(std::span<const std::byte> block) {
    std::string text;
    for (const std::byte byte : block)
        text += Format("%02x", std::to_integer<unsigned>(byte));
    return text;
}

std::vector<std::byte> ReadSized(const std::filesystem::path& path, std::size_t bytes) {
    std::vector<std::byte> file = tool::ReadAll(path.string());
    if (file.size() != bytes)
        throw tool::CommandError(tool::ExitCode::BadInput, path.string(),
                                 Format("%zu bytes: suite.json wants %zu", file.size(), bytes));
    return file;
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
    result.suite.cause = FindBlockCause(request, blocks);
    Finish(result, Outcome::Fail,
           result.suite.difference + Format("; %zu of %zu blocks differ; ", different, count) +
               (result.suite.cause.empty() ? "covers: " + blockCase.about
                                           : "looks like: " + result.suite.cause));
}

} // namespace

void RunBlockCases(const std::filesystem::path& folder, std::span<const BlockSuiteCase> cases,
                   Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add) {
    std::optional<CaseResult> pending; // what comes after an answer shows with the next, or at the end
    for (const BlockSuiteCase& blockCase : cases) {
        if (mustPassOnly && !blockCase.mustPass)
            continue;
        tool::ThrowIfInterrupted();
        CaseResult result;
        result.name = blockCase.name;
        result.about = blockCase.about;
        result.mustPass = blockCase.mustPass;
        const auto ended =
            RunGuarded(result, subject, [&] { CheckBlocks(folder, blockCase, subject, result); });
        if (mustPassOnly && ended == SubjectError::Kind::NotSupported)
            Finish(result, Outcome::Fail, result.reason + ", although it claims what the case needs");
        if (pending)
            add(*pending);
        pending = std::move(result);
    }
    if (!pending)
        return;
    const std::string unasked = subject.Finish();
    if (!unasked.empty() && pending->outcome == Outcome::Pass)
        Finish(*pending, Outcome::Fail, "adapter: " + unasked + ", after its answer");
    add(*pending);
}

} // namespace openntc::conformance
