// SPDX-License-Identifier: MIT
// Hostile files: prefixes, header bytes, mutated JSON, mutated weights, failing allocations. An error or a
// valid set.
//   OPENNTC_FUZZ_SEED=N   start of the sequence (default: another one each run, printed, so that a failure can be repeated)
//   OPENNTC_FUZZ_COUNT=N  mutations of the JSON (default 200000)
#include "fuzz/FuzzTarget.h"
#include "fuzz/JsonMutator.h"
#include "openntc/container/Writer.h"
#include "openntc/inference/Synthesis.h"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::fuzz;

namespace {

struct Base {
    std::string name;
    std::string file;
    std::string json; ///< without NUL
    std::span<const std::byte> binary;
};

std::span<const std::byte> BytesOf(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

void AddBase(std::vector<Base>& bases, std::string name, std::string file) {
    const std::span<const std::byte> bytes = BytesOf(file);
    container::HeaderBytes headerBytes;
    std::copy_n(bytes.begin(), headerBytes.size(), headerBytes.begin());
    const Expected<container::Header> header = container::DecodeHeader(headerBytes, bytes.size());
    REQUIRE_MESSAGE(header, name);
    Base base{std::move(name), std::move(file), {}, {}};
    base.json = base.file.substr(header->jsonOffset, header->jsonSize - 1);
    bases.push_back(std::move(base));
    Base& added = bases.back();
    added.binary = BytesOf(added.file).subspan(header->binaryOffset);
}

void AddSynthesised(std::vector<Base>& bases, const char* name, const SynthesisDesc& desc) {
    MemoryStream stream;
    const Expected<void> made = SynthesizeTextureSet(stream, desc);
    REQUIRE_MESSAGE(made, std::string(made.error().GetText()));
    const std::span<const std::byte> bytes = stream.GetBytes();
    AddBase(bases, name, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

/// The first of them are the project's own: two of generation 1, one each of generations 2 and 3.
constexpr std::size_t kOwnBases = 4;

const std::vector<Base>& GetBases() {
    static const std::vector<Base> bases = [] {
        std::vector<Base> made;
        made.reserve(64); // the spans point into the strings
        SynthesisDesc small;
        small.desc = {24, 20, 4, 4};
        small.shape = {4, 4, 8, 2, 4};
        AddSynthesised(made, "synthesised small", small);
        SynthesisDesc large;
        large.seed = 2;
        large.desc = {40, 64, 10, 6};
        large.shape = {2, 12, 16, 4, 8};
        large.withFP8 = true;
        large.channelColorSpaces = 0x1A5;
        AddSynthesised(made, "synthesised large, both networks", large);
        for (const int network : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
            SynthesisDesc layered;
            layered.desc = {40, 24, 6, 4};
            layered.networkVersion = network;
            layered.shape = MakeLayeredShape(2, 8);
            layered.withFP8 = true;
            layered.compression = {network == NTC_NETWORK_GENERATION_3, false, 4, 9.0f};
            AddSynthesised(
                made, network == NTC_NETWORK_GENERATION_2 ? "synthesised gen2" : "synthesised gen3", layered);
        }
        const char* shared = std::getenv("OPENNTC_SHARED_DIR");
        const std::filesystem::path folder =
            std::filesystem::path(shared != nullptr ? shared : OPENNTC_DEFAULT_SHARED_DIR) / "conformance";
        std::error_code none;
        std::vector<std::filesystem::path> files;
        for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
            if (entry.path().extension() == ".ntc")
                files.push_back(entry.path());
        }
        std::sort(files.begin(), files.end());
        for (const std::filesystem::path& path : files) {
            std::ifstream stream(path, std::ios::binary);
            AddBase(made, path.filename().string(), {std::istreambuf_iterator<char>(stream), {}});
        }
        if (files.empty())
            MESSAGE("SKIP: no conformance vectors as further base files");
        return made;
    }();
    return bases;
}

std::uint64_t NumberFromEnvironment(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

/// One for the whole run; every test case says it, so that its failure can be repeated.
std::uint64_t GetSeed() {
    static const std::uint64_t seed = [] {
        const auto now = std::chrono::system_clock::now().time_since_epoch().count();
        return NumberFromEnvironment("OPENNTC_FUZZ_SEED", static_cast<std::uint64_t>(now) % 1000000007u);
    }();
    return seed;
}

/// Overwrites a few bytes of a binary chunk.
void MutateBytes(Random& random, std::string& binary) {
    for (std::size_t i = 1 + random.Below(4); i > 0 && !binary.empty(); --i)
        binary[random.Below(binary.size())] = static_cast<char>(random.Below(256));
}

/// Header and JSON of a file whose binary chunk follows.
std::string MakeFront(const std::string& json, std::uint64_t binarySize) {
    container::Header header;
    header.jsonSize = json.size() + 1;
    header.binaryOffset = (container::kHeaderBytes + header.jsonSize + 3) & ~std::uint64_t{3};
    header.binarySize = binarySize;
    const container::HeaderBytes bytes = container::EncodeHeader(header);
    std::string front(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    front += json;
    front.resize(static_cast<std::size_t>(header.binaryOffset));
    return front;
}

} // namespace

TEST_CASE("fuzz: the base files load") {
    for (const Base& base : GetBases()) {
        CAPTURE(base.name);
        const Outcome outcome = LoadEverything(BytesOf(base.file), {});
        CHECK(outcome.broken == nullptr);
        CHECK_MESSAGE(outcome.isTextureSet, outcome.message);
        // The two-part form is the same file.
        CHECK(LoadEverything(BytesOf(MakeFront(base.json, base.binary.size())), base.binary).isTextureSet ==
              outcome.isTextureSet);
    }
}

TEST_CASE("fuzz: every prefix of every file is refused") {
    for (const Base& base : GetBases()) {
        CAPTURE(base.name);
        for (std::size_t length = 0; length < base.file.size(); ++length) {
            ReadOnlyMemoryStream stream(BytesOf(base.file).first(length));
            REQUIRE_FALSE(container::ReadContainer(stream));
        }
    }
}

TEST_CASE("fuzz: every prefix of the JSON text, and binary chunks cut short, with a header that fits") {
    for (const Base& base : GetBases()) {
        CAPTURE(base.name);
        for (std::size_t length = 0; length < base.json.size(); ++length) {
            const std::string front = MakeFront(base.json.substr(0, length), base.binary.size());
            TwoPartStream stream(BytesOf(front), base.binary);
            REQUIRE_FALSE(container::ReadContainer(stream));
        }
        for (std::size_t size = 0; size < base.binary.size(); size += 1 + base.binary.size() / 257) {
            const Outcome outcome =
                LoadEverything(BytesOf(MakeFront(base.json, size)), base.binary.first(size));
            REQUIRE(outcome.broken == nullptr);
            REQUIRE_FALSE(outcome.isTextureSet);
        }
    }
}

TEST_CASE("fuzz: every change of one byte of the header") {
    for (const Base& base : GetBases()) {
        CAPTURE(base.name);
        std::string front = base.file.substr(0, container::kHeaderBytes);
        const std::span<const std::byte> rest = BytesOf(base.file).subspan(container::kHeaderBytes);
        for (std::size_t at = 0; at < front.size(); ++at) {
            const char original = front[at];
            for (int change = 1; change < 256; ++change) {
                front[at] = static_cast<char>(static_cast<unsigned char>(original) ^ change);
                const Outcome outcome = LoadEverything(BytesOf(front), rest);
                CAPTURE(at);
                CAPTURE(change);
                REQUIRE(outcome.broken == nullptr);
                if (at < 8)
                    REQUIRE_FALSE(outcome.isContainer);
            }
            front[at] = original;
        }
    }
}

TEST_CASE("fuzz: structure-aware mutations of the JSON and of the binary chunk") {
    const std::uint64_t seed = GetSeed();
    const std::uint64_t count = NumberFromEnvironment("OPENNTC_FUZZ_COUNT", 200000);
    std::vector<JsonMutator> mutators;
    for (const Base& base : GetBases())
        mutators.emplace_back(base.json);
    std::size_t containers = 0;
    std::size_t sets = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        Random random(seed + i);
        // Half of the mutations start from the two small files that the project makes itself; of those files,
        // whose binary chunks are small enough to be copied, a quarter has other bytes there too.
        const std::size_t which = random.Below(2) == 0 ? random.Below(2) : random.Below(mutators.size());
        const Base& base = GetBases()[which];
        std::string binary;
        const bool otherBytes = which < kOwnBases && random.Below(4) == 0;
        if (otherBytes) {
            binary.assign(reinterpret_cast<const char*>(base.binary.data()), base.binary.size());
            MutateBytes(random, binary);
        }
        const std::string json = random.Below(8) == 0 ? base.json : mutators[which].Mutate(random);
        const std::string front = MakeFront(json, base.binary.size());
        const Outcome outcome = LoadEverything(BytesOf(front), otherBytes ? BytesOf(binary) : base.binary);
        containers += outcome.isContainer ? 1 : 0;
        sets += outcome.isTextureSet ? 1 : 0;
        if (outcome.broken != nullptr) {
            const std::string message = std::string("OPENNTC_FUZZ_SEED=") + std::to_string(seed + i) +
                                        " OPENNTC_FUZZ_COUNT=1, base " + base.name +
                                        ": broken: " + outcome.broken + ": \"" + outcome.message + "\"\n" +
                                        json;
            FAIL(message);
        }
    }
    MESSAGE("fuzz: OPENNTC_FUZZ_SEED=" << seed << ", " << count << " mutations: " << containers
                                       << " containers and " << sets << " texture sets accepted");
    // The mutations must not all die at the door, and not all be harmless either.
    if (count >= 1000) {
        CHECK(containers > sets);
        CHECK(sets > count / 100);
        CHECK(sets < count * 9 / 10);
    }
}

TEST_CASE("fuzz: random bytes in the binary chunk of a sound file") {
    for (std::size_t which = 0; which < kOwnBases; ++which) {
        const Base& base = GetBases()[which];
        const std::string original(reinterpret_cast<const char*>(base.binary.data()), base.binary.size());
        const std::string front = MakeFront(base.json, original.size());
        for (std::uint64_t i = 0; i < 2000; ++i) {
            CAPTURE(GetSeed() + i);
            Random random(GetSeed() + i);
            std::string binary = original;
            MutateBytes(random, binary);
            const Outcome outcome = LoadEverything(BytesOf(front), BytesOf(binary));
            REQUIRE_MESSAGE(outcome.broken == nullptr, outcome.message);
        }
    }
}

TEST_CASE("fuzz: each failing allocation of a load is OutOfMemory without a leak") {
    for (const Base& base : GetBases()) {
        CAPTURE(base.name);
        openntc::test::CountingAllocator counting;
        {
            ReadOnlyMemoryStream stream(BytesOf(base.file));
            REQUIRE(TextureSetMetadata::Load(stream, counting));
        }
        for (std::size_t n = 0; n < counting.GetAllocationCount(); ++n) {
            openntc::test::CountingAllocator failing;
            failing.FailAt(n);
            ReadOnlyMemoryStream stream(BytesOf(base.file));
            const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream, failing);
            REQUIRE_FALSE(set);
            CHECK(set.error().GetStatus() == Status::OutOfMemory);
            CHECK(failing.GetUsedBytes() == 0);
        }
    }
}
