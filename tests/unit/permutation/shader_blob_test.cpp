// SPDX-License-Identifier: MIT
// Blobs of shader permutations: lookup, the errors that name what is missing, and damaged files.
#include "support/CountingAllocator.h"

#include "openntc/permutation/ShaderBlob.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

using namespace openntc;

namespace {

struct Entry {
    std::string key;
    std::vector<std::uint32_t> words;
};

// Written from the description in ShaderBlob.h, with the index lines as given.
std::vector<std::uint32_t> MakeBlob(const std::vector<Entry>& entries, const std::string& leftOut = "") {
    std::size_t textBytes = 13 + 18 + leftOut.size() + 1;
    for (const Entry& entry : entries)
        textBytes += 8 + 1 + 8 + 1 + entry.key.size() + 1;
    textBytes = (textBytes + 3) / 4 * 4;
    char numbers[32];
    const auto print = [&](std::size_t a, std::size_t b) {
        std::snprintf(numbers, sizeof(numbers), "%08zx %08zx", a, b);
        return std::string(numbers);
    };
    std::string text = "NTCSHADERS 1\n" + print(entries.size(), textBytes) + "\n" + leftOut + "\n";
    std::size_t offset = textBytes;
    for (const Entry& entry : entries) {
        text += print(offset, 4 * entry.words.size()) + " " + entry.key + "\n";
        offset += 4 * entry.words.size();
    }
    text.resize(textBytes, '\n');
    std::vector<std::uint32_t> words(textBytes / 4);
    std::memcpy(words.data(), text.data(), textBytes);
    for (const Entry& entry : entries)
        words.insert(words.end(), entry.words.begin(), entry.words.end());
    return words;
}

std::vector<std::uint32_t> MakeModule(std::uint32_t tail, std::size_t extra = 0) {
    std::vector<std::uint32_t> words = {0x07230203u, tail};
    words.resize(2 + extra, tail);
    return words;
}

// ':' sorts before '|', so that "a.comp:Second" comes before "a.comp".
const std::vector<Entry> kEntries = {
    {"a.comp:Second|A=1", MakeModule(1)},       {"a.comp|", MakeModule(2)},
    {"a.comp|A=1", MakeModule(3, 5)},           {"a.comp|A=1 B=2 C=3", MakeModule(4)},
    {"a.comp|A=1 B=3 C=3", MakeModule(5)},      {"b.comp|A=1", MakeModule(6)},
    {"z\xC3\xA9.comp.hlsl|B=7", MakeModule(7)},
};

std::uint32_t FindTail(const ShaderBlob& blob, std::string_view source, std::string_view defines) {
    const auto found = blob.Find(source, defines);
    return found ? found->back() : 0;
}

void CheckMissing(const ShaderBlob& blob, std::string_view source, std::string_view defines,
                  const std::string& text) {
    const auto found = blob.Find(source, defines);
    REQUIRE_FALSE(found);
    CHECK(found.error().GetStatus() == Status::ShaderUnavailable);
    CHECK(std::string(found.error().GetText()) == text);
}

// Every module that an accepted blob gives out lies inside it.
void UseEverything(std::span<const std::uint32_t> words) {
    const auto blob = ShaderBlob::Open(words);
    if (!blob) {
        CHECK(blob.error().GetStatus() == Status::FileUnrecognized);
        return;
    }
    std::size_t count = 0;
    blob->ForEach([&](const ShaderBlob::Shader& shader) {
        CHECK(shader.words.data() >= words.data());
        CHECK(shader.words.data() + shader.words.size() <= words.data() + words.size());
        CHECK(shader.words.front() == 0x07230203u);
        CHECK(blob->Find(shader.key.source, "NO=1").has_value() == false);
        ++count;
    });
    CHECK(count == blob->GetCount());
}

} // namespace

TEST_CASE("shader blob: every permutation is found, by defines in any order") {
    const auto words = MakeBlob(kEntries);
    const auto blob = ShaderBlob::Open(words);
    REQUIRE(blob);
    CHECK(blob->GetCount() == 7);
    CHECK(FindTail(*blob, "a.comp:Second", "A=1") == 1);
    CHECK(FindTail(*blob, "a.comp", "") == 2);
    CHECK(FindTail(*blob, "a.comp", "A=1") == 3);
    CHECK(FindTail(*blob, "a.comp", "C=3 B=2  A=1 ") == 4);
    CHECK(FindTail(*blob, "a.comp", "B=3 A=1 C=3") == 5);
    CHECK(FindTail(*blob, "b.comp", "A=1") == 6);
    CHECK(FindTail(*blob, "z\xC3\xA9.comp.hlsl", "B=7") == 7);
    CHECK(blob->Find("a.comp", "A=1")->size() == 7);
}

// Written once by openntc_add_shaders(OUTPUT BLOB)'s script from kEntries; blobs outlive the version that made them.
TEST_CASE("shader blob: the golden file is still read, and what the description says") {
    std::ifstream file(OPENNTC_TEST_DATA_DIR "/golden/shader_blob_1.bin", std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    REQUIRE(bytes.size() % 4 == 0);
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), bytes.size());
    CHECK((words == MakeBlob(kEntries, "NTC_MATH=6 NTC_MATH=7")));
    const auto blob = ShaderBlob::Open(words);
    REQUIRE(blob);
    CHECK(blob->GetCount() == kEntries.size());
    CHECK(FindTail(*blob, "a.comp", "B=2 C=3 A=1") == 4);
    CHECK(FindTail(*blob, "z\xC3\xA9.comp.hlsl", "B=7") == 7);
    CHECK_FALSE(blob->Find("b.comp", "A=1 NTC_MATH=6"));
}

TEST_CASE("shader blob: a missing permutation is named with the nearest") {
    const auto words = MakeBlob(kEntries, "NTC_MATH=6 NTC_MATH=7");
    const auto blob = ShaderBlob::Open(words);
    REQUIRE(blob);
    CheckMissing(*blob, "a.comp", "A=1 B=4 C=3",
                 "shader: a.comp A=1 B=4 C=3: not among the 7 permutations compiled; nearest: A=1 B=2 C=3, "
                 "or A=1 B=3 C=3");
    CheckMissing(*blob, "b.comp", "A=2",
                 "shader: b.comp A=2: not among the 7 permutations compiled; nearest: A=1");
    CheckMissing(*blob, "c.comp", "A=2",
                 "shader: c.comp: no such source among the 7 permutations compiled; there is a.comp:Second");
    CheckMissing(*blob, "a.comp", "A=1 NTC_MATH=7",
                 "shader: a.comp A=1 NTC_MATH=7: left out: cooperative vectors and matrices need GLSL and a "
                 "glslang that knows "
                 "GL_NV_cooperative_vector");
    CheckMissing(*blob, "a.comp", "A=1 NTC_MATH=8",
                 "shader: a.comp A=1 NTC_MATH=8: not among the 7 permutations compiled; nearest: A=1, or ");
    const auto none = MakeBlob({});
    const auto empty = ShaderBlob::Open(none);
    REQUIRE(empty);
    CheckMissing(*empty, "a.comp", "",
                 "shader: a.comp: no such source among the 0 permutations compiled; there is ");
}

TEST_CASE("shader blob: what breaks a rule of the format is refused") {
    const auto refuses = [](const std::vector<Entry>& entries, const std::string& text) {
        const auto words = MakeBlob(entries);
        const auto blob = ShaderBlob::Open(words);
        REQUIRE_FALSE(blob);
        CHECK(blob.error().GetStatus() == Status::FileUnrecognized);
        CHECK(std::string(blob.error().GetText()) == text);
    };
    refuses({{"b|", MakeModule(1)}, {"a|", MakeModule(1)}}, "index: line 2: \"SOURCE|DEFINES\", sorted");
    refuses({{"b|", MakeModule(1)}, {"b|", MakeModule(1)}}, "index: line 2: \"SOURCE|DEFINES\", sorted");
    refuses({{"b", MakeModule(1)}}, "index: line 1: \"SOURCE|DEFINES\", sorted");
    refuses({{"|", MakeModule(1)}}, "index: line 1: \"SOURCE|DEFINES\", sorted");
    refuses({{"b|", {0x03022307u}}}, "index: line 1: offset 56: no SPIR-V is there");
    refuses({{"b|", {}}},
            "index: line 1: offset 56, size 0: words after 56 bytes of index, at most the file's 56 bytes");
}

TEST_CASE("shader blob: cut and changed files never lead outside") {
    const auto words = MakeBlob(kEntries, "NTC_MATH=6");
    for (std::size_t size = 0; size <= words.size(); ++size)
        UseEverything(
            std::vector<std::uint32_t>(words.begin(), words.begin() + static_cast<std::ptrdiff_t>(size)));
    // Every byte of the index, with values that matter to the parser; then several bytes at once.
    const std::size_t bytes = 4 * words.size();
    for (std::size_t at = 0; at < bytes; ++at) {
        for (const char value : {'\0', '\n', ' ', '0', '9', 'f', 'g', '|', '~', '\xFF'}) {
            auto copy = words;
            std::memcpy(reinterpret_cast<char*>(copy.data()) + at, &value, 1);
            UseEverything(copy);
        }
    }
    std::mt19937 random(1);
    for (int round = 0; round < 5000; ++round) {
        auto copy = words;
        for (int change = 0; change < 4; ++change) {
            const char value = "0123456789abcdef|\n "[random() % 19];
            std::memcpy(reinterpret_cast<char*>(copy.data()) + random() % bytes, &value, 1);
        }
        UseEverything(copy);
    }
}

TEST_CASE("shader blob: reading reports sizes that cannot be and memory that runs out") {
    const auto words = MakeBlob(kEntries);
    const auto bytes = std::as_bytes(std::span(words));
    ReadOnlyMemoryStream whole(bytes);
    const auto read = ReadShaderBlob(whole);
    REQUIRE(read);
    CHECK(std::vector<std::uint32_t>(read->begin(), read->end()) == words);
    ReadOnlyMemoryStream cut(bytes.first(bytes.size() - 1));
    CHECK(ReadShaderBlob(cut).error().GetStatus() == Status::FileUnrecognized);
    test::CountingAllocator allocator;
    allocator.FailAt(0);
    CHECK(ReadShaderBlob(whole, allocator).error().GetStatus() == Status::OutOfMemory);
    CHECK(allocator.GetUsedBytes() == 0);
}

TEST_CASE("a permutation that covers a key is found in a blob") {
    const std::vector<std::uint32_t> words =
        MakeBlob({{"a.comp:Second|NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x3", MakeModule(1)},
                  {"a.comp|NETWORK_VERSION=1 NTC_MATH=1", MakeModule(2)},
                  {"a.comp|NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7", MakeModule(3)},
                  {"b.comp|NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x3", MakeModule(4)}},
                 "NTC_MATH=6");
    const auto blob = ShaderBlob::Open(words);
    REQUIRE(blob);
    PermutationKey key;
    REQUIRE(ReadDefines("NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x3 NTC_LINEARISE=0", "",
                        ShaderLanguage::Glsl, key));
    auto found = blob->FindCovering("a.comp", key);
    REQUIRE_MESSAGE(found.has_value(), std::string(found.error().GetText()));
    CHECK(found->words.back() == 3);
    CHECK(found->defines == "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7");
    CHECK(found->key.effects[NTC_EFFECT_OUTPUT_MASK] == 0x7);
    key.effects[NTC_EFFECT_OUTPUT_MASK] = 0x8;
    CHECK(blob->FindCovering("a.comp", key)->words.back() == 2);
    found = blob->FindCovering("b.comp", key);
    REQUIRE_FALSE(found);
    CHECK(std::string(found.error().GetText()).find("b.comp: none of 4 permutations covers the scene: add") !=
          std::string::npos);
    CHECK_FALSE(blob->FindCovering("c.comp", key));
    key.math = NTC_MATH_COOPVEC_INT8;
    found = blob->FindCovering("a.comp", key);
    REQUIRE_FALSE(found);
    CHECK(std::string(found.error().GetText()).find("left out") != std::string::npos);
}
