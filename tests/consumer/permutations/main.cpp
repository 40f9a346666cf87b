// SPDX-License-Identifier: MIT
// consumer PERMUTATIONS.bin LISTED.bin: every permutation asked for is there, and a missing one is named.
#include "consumer_shaders.h"

#include "openntc/core/FileStream.h"
#include "openntc/permutation/ShaderBlob.h"

#include <cstdio>
#include <cstdlib>
#include <string>

namespace {

void Require(bool condition, const char* what) {
    if (condition)
        return;
    std::fprintf(stderr, "wrong: %s\n", what);
    std::exit(1);
}

void RequireError(const openntc::Expected<std::span<const std::uint32_t>>& result, const char* part) {
    const std::string text = result ? "found" : result.error().GetText();
    std::printf("%s\n", text.c_str());
    Require(!result && result.error().GetStatus() == openntc::Status::ShaderUnavailable, part);
    Require(text.find(part) != std::string::npos, part);
}

openntc::Array<std::uint32_t> Read(const char* path) {
    auto stream = openntc::FileReader::Open(path);
    Require(stream.has_value(), path);
    auto words = openntc::ReadShaderBlob(*stream);
    Require(words.has_value(), path);
    return std::move(*words);
}

} // namespace

int main(int argc, char** argv) {
    Require(argc == 3, "two blobs");
    const auto words = Read(argv[1]);
    const auto blob = openntc::ShaderBlob::Open(words.AsSpan());
    Require(blob.has_value(), "blob");
    for (const char* source : {"first.comp", "second.frag.hlsl"}) {
        for (const char* version : {"1", "4"}) {
            for (const char* shape : {"0", "1"}) {
                const std::string defines =
                    std::string("SHAPE=") + shape + " NTC_MATH=1 NETWORK_VERSION=" + version;
                const auto shader = blob->Find(source, defines);
                Require(shader && shader->front() == 0x07230203u, defines.c_str());
            }
        }
    }
    const auto header = consumer_shaders::FindShader("first.comp", "NETWORK_VERSION=1 NTC_MATH=1 SHAPE=0");
    const auto same = blob->Find("first.comp", "NETWORK_VERSION=1 NTC_MATH=1 SHAPE=0");
    Require(header && std::equal(header->begin(), header->end(), same->begin(), same->end()),
            "header and blob agree");

    // A scene of few channels, stored values: compiled in full, found all the same, SHAPE being the project's own.
    openntc::PermutationKey key;
    for (const auto language : {openntc::ShaderLanguage::Glsl, openntc::ShaderLanguage::Hlsl}) {
        Require(openntc::ReadDefines("NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0", "",
                                     language, key),
                "definitions");
        const bool isGlsl = language == openntc::ShaderLanguage::Glsl;
        const char* source = isGlsl ? "first.comp" : "second.frag.hlsl";
        const auto exact = blob->Find(source, "NETWORK_VERSION=1 NTC_MATH=1 SHAPE=0");
        const auto covering = blob->FindCovering(source, key, "SHAPE=0");
        Require(covering && covering->words.data() == exact->data(), "covering in the blob");
        const auto embedded = consumer_shaders::FindCoveringShader(source, key, "SHAPE=0");
        Require(embedded &&
                    std::equal(embedded->words.begin(), embedded->words.end(), exact->begin(), exact->end()),
                "covering in the header");
        Require(!blob->FindCovering(source, key) && !consumer_shaders::FindCoveringShader(source, key),
                "none without SHAPE");
    }
    key.math = NTC_MATH_COOPVEC_INT8;
    const auto leftOut = consumer_shaders::FindCoveringShader("second.frag.hlsl", key, "SHAPE=0");
    Require(!leftOut && std::string(leftOut.error().GetText()).find("left out") != std::string::npos,
            "left out, covering");

    constexpr const char* kCoopVec = "NETWORK_VERSION=1 NTC_MATH=6 SHAPE=0";
    const std::string wrong = "NETWORK_VERSION=1 NTC_MATH=1 SHAPE=2";
    RequireError(blob->Find("second.frag.hlsl", kCoopVec), "left out: cooperative vectors and matrices need");
    RequireError(consumer_shaders::FindShader("second.frag.hlsl", kCoopVec),
                 "left out: cooperative vectors and matrices need");
    RequireError(blob->Find("first.comp", wrong),
                 "first.comp NETWORK_VERSION=1 NTC_MATH=1 SHAPE=2: not among the");
    RequireError(blob->Find("first.comp", wrong), "nearest: NETWORK_VERSION=1 NTC_MATH=1 SHAPE=");
    RequireError(blob->Find("fourth.comp", wrong), "fourth.comp: no such source");

    const auto listedWords = Read(argv[2]);
    const auto listed = openntc::ShaderBlob::Open(listedWords.AsSpan());
    Require(listed && listed->GetCount() == 6 + 1 + 1 + 2, "ten listed permutations");
    Require(listed->Find("third.hlsl:Fill", "SIZE=16 COLOUR=3").has_value(), "third.hlsl:Fill");
    Require(listed->Find("second.frag.hlsl", "NETWORK_VERSION=4 SHAPE=1").has_value(), "second.frag.hlsl");
    Require(listed->Find("second.frag.hlsl:Twice", "SHAPE=0 NETWORK_VERSION=1").has_value(),
            "second.frag.hlsl:Twice");
    Require(listed->Find("first.comp", "SHAPE=0 NETWORK_VERSION=3").has_value(), "first.comp");
    std::size_t visited = 0;
    listed->ForEach([&](const openntc::ShaderBlob::Shader& shader) {
        const auto found = listed->Find(shader.key.source, shader.key.defines);
        Require(found && found->data() == shader.words.data(), "ForEach agrees with Find");
        ++visited;
    });
    Require(visited == listed->GetCount(), "ForEach visits all");
    return 0;
}
