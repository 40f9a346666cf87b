// SPDX-License-Identifier: MIT
#include "TextureRunner.h"

#include "GuardedCase.h"

#include "../TextureSet.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

using tool::Format;

/// The textures of a case's file: each the least, then the greatest.
TextureRange ReadRange(const std::filesystem::path& path, const TextureRequest& request) {
    std::size_t bytes = 0;
    for (const TextureOutput& output : request.outputs)
        bytes += 2 * request.GetTextureBytes(output);
    const std::vector<std::byte> file = ReadSized(path, bytes);
    TextureRange range;
    std::span<const std::byte> rest = file;
    for (const TextureOutput& output : request.outputs) {
        for (Textures* textures : {&range.least, &range.greatest}) {
            const auto part = rest.first(request.GetTextureBytes(output));
            textures->emplace_back(part.begin(), part.end());
            rest = rest.subspan(part.size());
        }
    }
    return range;
}

bool HasSizes(const TextureRequest& request, const Textures& textures) {
    bool has = textures.size() == request.outputs.size();
    for (std::size_t n = 0; has && n < textures.size(); ++n)
        has = textures[n].size() == request.GetTextureBytes(request.outputs[n]);
    return has;
}

void CheckTextures(const std::filesystem::path& folder, const TextureSuiteCase& textureCase, Subject& subject,
                   CaseResult& result) {
    const TextureRequest& request = textureCase.request;
    const Capabilities capabilities = subject.GetCapabilities();
    if (!capabilities.textures || !capabilities.math[static_cast<std::size_t>(request.math)])
        return Finish(result, Outcome::Skip,
                      std::string("not supported: ") +
                          (capabilities.textures ? tool::GetName(request.math) : "textures"));
    const std::string path = (folder / textureCase.set).string();
    const TextureRange expected = ReadRange(folder / textureCase.values, request);
    const std::vector<std::byte> file = tool::ReadAll(path);
    const tool::TextureSet set = tool::LoadTextureSet(path); // says what is wrong with it
    const Model model(file);
    const std::span<const ColorMip> mips = set.metadata.GetColorMips();
    const auto mip = static_cast<std::size_t>(request.mip);
    if (mip >= mips.size() || request.FindProblem(mips[mip].width, mips[mip].height) != nullptr)
        throw tool::CommandError(tool::ExitCode::BadInput, path, "textures: rect: outside the mip");
    subject.Open(path);
    const Textures textures = subject.MakeTextures(request);
    if (!HasSizes(request, textures))
        return Finish(result, Outcome::Fail, "textures: not as many bytes as they have");
    const float flushBelow = GetFlushLimit(subject.GetArithmetic(), request.math);
    const TextureDifference difference = CompareTextures(request, textures, expected, flushBelow);
    result.suite.texels = difference.components / 4;
    if (difference.different == 0)
        return Finish(result, Outcome::Pass, Format("%zu texels; ", result.suite.texels) + textureCase.about);
    result.suite.difference = difference.first;
    TextureModel wrong(model, request);
    result.suite.cause = FindOneCause(ListTextureMistakes(), [&](TextureMistake mistake) {
        return CompareTextures(request, textures, wrong.MakeRange(mistake), flushBelow).different == 0;
    });
    FinishDifferent(result,
                    Format("%zu of %zu components differ", difference.different, difference.components),
                    textureCase.about);
}

} // namespace

void RunTextureCases(const std::filesystem::path& folder, std::span<const TextureSuiteCase> cases,
                     Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add) {
    RunCaseList(cases, subject, mustPassOnly, add, [&](const TextureSuiteCase& one, CaseResult& result) {
        CheckTextures(folder, one, subject, result);
    });
}

} // namespace openntc::conformance
