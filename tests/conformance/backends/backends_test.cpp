// SPDX-License-Identifier: MIT
// Every back end of the command line against the specification's vectors V1 and V2, LibNTC's recorded texels,
// and each other over whole mips.
#include "support/SpecificationVectors.h"
#include "support/Vectors.h"

#include "Decoder.h"
#include "Failure.h"
#include "conformance/Runner.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"
#include "openntc/core/Half.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;
namespace fs = std::filesystem;

namespace {

#ifdef OPENNTC_TEST_SANITIZED
constexpr bool kLeavesOutLarge = true;
#else
constexpr bool kLeavesOutLarge = false;
#endif

struct NamedBackend {
    std::string name;
    tool::BackendOptions options;
};

// Under a cap of instruction sets the portable kernel, which needs none of them and is twenty times as fast, takes the
// reference's place: the run without a cap shows that they give the same bits.
// Vulkan tests run on Mesa's CPU device unless OPENNTC_TEST_DEVICE names another.
std::vector<NamedBackend> ListBackends() {
    std::vector<NamedBackend> backends;
    if (std::getenv("OPENNTC_SIMD_CAP") == nullptr)
        backends.push_back({"reference", {tool::Backend::Reference, {}, {}, 1}});
    for (const auto& [simd, name] : tool::ListSimdTargets())
        backends.push_back({std::string("cpu-") + name, {tool::Backend::Cpu, {}, simd, 0}});
    const char* device = std::getenv("OPENNTC_TEST_DEVICE");
    backends.push_back({"vulkan", {tool::Backend::Vulkan, device != nullptr ? device : "llvmpipe", {}, 0}});
    return backends;
}

std::string GetConformanceDirectory() {
    const char* shared = std::getenv("OPENNTC_SHARED_DIR");
    return (fs::path(shared != nullptr ? shared : OPENNTC_DEFAULT_SHARED_DIR) / "conformance").string();
}

// The decoder, or null with the reason printed.
std::unique_ptr<tool::Decoder> MakeDecoderOrSkip(const tool::DecodeData& data, const NamedBackend& backend) {
    Expected<std::unique_ptr<tool::Decoder>> decoder = tool::MakeDecoder(data, backend.options);
    if (decoder)
        return std::move(*decoder);
    if (decoder.error().GetStatus() == Status::Unsupported) {
        const std::string reason = "SKIP: " + backend.name + ": " + decoder.error().GetText();
        MESSAGE(reason);
    } else {
        FAIL(std::string(decoder.error().GetText()));
    }
    return nullptr;
}

std::vector<float> DecodeMip(tool::Decoder& decoder, const TextureSetMetadata& metadata, int mip,
                             DecodeMath math) {
    const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    std::vector<float> outputs(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height) *
                               16);
    const auto decoded = decoder.Decode(mip, {0, 0, size.width, size.height}, {math, false}, outputs);
    INFO((decoded ? "" : std::string(decoded.error().GetText())));
    REQUIRE(decoded);
    return outputs;
}

// Expected CRC-32s of all outputs of a mip: binary16 of the half epilogue, binary32 of the float epilogue
// (format specification, test vectors).
struct MipCrc {
    std::uint32_t half;
    std::uint32_t single;
};
const std::vector<MipCrc> kV1 = {
    {0xbf80e76f, 0x007d97d0}, {0x2b2db22a, 0x753fadfb}, {0x01aa6b12, 0xa0be28f5}, {0x16f196a5, 0x15b5c1e1}};
const std::vector<MipCrc> kV2 = {{0x4484fd84, 0x9f75f00c}, {0x3ba32a83, 0xd3342cd7},
                                 {0xd30af414, 0xf06d2b91}, {0x0426cc42, 0x7cc52f91},
                                 {0x0b35c34c, 0x3f6c89f8}, {0x45d68f0c, 0x265b6c2f}};

std::uint32_t GetHalfCrc(const std::vector<float>& values) {
    std::vector<std::uint16_t> halves;
    for (const float value : values)
        halves.push_back(FloatToHalf(value));
    return Crc32(std::as_bytes(std::span(halves)));
}

void CheckVector(const char* name, const std::vector<std::byte>& file, const std::vector<MipCrc>& expected) {
    const fs::path path = fs::temp_directory_path() / ("openntc-backends-" + std::string(name) + ".ntc");
    {
        auto writer = FileWriter::Create(path);
        REQUIRE(writer);
        REQUIRE(writer->Write(file.data(), file.size()));
        REQUIRE(writer->Commit());
    }
    int ran = 0;
    int skipped = 0;
    for (const NamedBackend& backend : ListBackends()) {
        CAPTURE(backend.name);
        tool::TextureSet set = tool::LoadTextureSet(path.string());
        const tool::DecodeData data = tool::LoadDecodeData(set);
        const std::unique_ptr<tool::Decoder> decoder = MakeDecoderOrSkip(data, backend);
        if (decoder == nullptr) {
            skipped += static_cast<int>(expected.size());
            continue;
        }
        REQUIRE(set.metadata.GetColorMips().size() == expected.size());
        for (std::size_t mip = 0; mip < expected.size(); ++mip) {
            CAPTURE(mip);
            const int level = static_cast<int>(mip);
            const std::vector<float> single = DecodeMip(*decoder, set.metadata, level, DecodeMath::Int8);
            CHECK(Crc32(std::as_bytes(std::span(single))) == expected[mip].single);
            CHECK(GetHalfCrc(DecodeMip(*decoder, set.metadata, level, DecodeMath::Int8Half)) ==
                  expected[mip].half);
            ++ran;
        }
    }
    fs::remove(path);
    ReportVectors(name, ran, skipped);
}

} // namespace

TEST_CASE("V1 and V2: whole mips, both epilogues, every back end") {
    CheckVector("V1", SynthesizeV1(), kV1);
    CheckVector("V2", SynthesizeV2(), kV2);
}

TEST_CASE("recorded texels of LibNTC, every back end") {
    const std::string folder = GetConformanceDirectory();
    if (!fs::is_directory(folder)) {
        MESSAGE("SKIP: no conformance vectors at $OPENNTC_SHARED_DIR/conformance");
        ReportVectors("recorded-texels", 0, 1);
        return;
    }
    for (const NamedBackend& backend : ListBackends()) {
        CAPTURE(backend.name);
        try {
            const conformance::Totals totals =
                conformance::RunFolder(folder, backend.options, [](const conformance::CaseResult& result) {
                    const std::string line = result.GetLine();
                    INFO(line);
                    CHECK(result.outcome != conformance::Outcome::Fail);
                    // These two sets have known fidelity: PSNR over the recorded texels cannot be far from
                    // that of the whole images, 40.18 and 43.49 dB.
                    if (result.name.starts_with("helmet-") && result.outcome == conformance::Outcome::Pass) {
                        REQUIRE(result.texels.psnr);
                        CHECK(*result.texels.psnr > 35);
                        CHECK(*result.texels.psnr < 50);
                    }
                });
            CHECK(totals.passed > 0);
            ReportVectors(("recorded-texels-" + backend.name).c_str(), totals.passed, totals.skipped);
        } catch (const tool::CommandError& error) {
            const std::string line = "SKIP: " + error.GetLine();
            MESSAGE(line);
            CHECK(error.GetCode() == tool::ExitCode::NoDevice);
            ReportVectors(("recorded-texels-" + backend.name).c_str(), 0, 1);
        }
    }
}

TEST_CASE("whole mips: every back end gives the bits of the reference") {
    const std::string folder = GetConformanceDirectory();
    std::error_code error;
    int ran = 0;
    int skipped = 0;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (!name.ends_with(".ntc") ||
            !fs::exists(entry.path().string().substr(0, entry.path().string().size() - 4) + ".expect.json"))
            continue;
        CAPTURE(name);
        tool::TextureSet set = tool::LoadTextureSet(entry.path().string());
        const tool::DecodeData data = tool::LoadDecodeData(set);
        const std::vector<NamedBackend> backends = ListBackends();
        std::vector<std::unique_ptr<tool::Decoder>> decoders;
        for (const NamedBackend& backend : backends)
            decoders.push_back(MakeDecoderOrSkip(data, backend));
        const auto isLarge = [&](int mip) {
            return set.metadata.GetColorMips()[static_cast<std::size_t>(mip)].width > 128;
        };
        if (kLeavesOutLarge && isLarge(0))
            MESSAGE("SKIP: " << name << ": mips wider than 128 texels: minutes under sanitizers");
        for (int mip = 0; mip < set.metadata.GetDesc().mips; ++mip) {
            // The half epilogue of the large sets is left to the recorded texels: the reference takes its
            // time.
            const bool large = isLarge(mip);
            if (kLeavesOutLarge && large)
                continue;
            for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
                if (large && math == DecodeMath::Int8Half)
                    continue;
                const std::vector<float> expected = DecodeMip(*decoders[0], set.metadata, mip, math);
                for (std::size_t i = 1; i < decoders.size(); ++i) {
                    CAPTURE(backends[i].name);
                    CAPTURE(mip);
                    if (decoders[i] == nullptr) {
                        ++skipped;
                        continue;
                    }
                    const float flush = backends[i].options.backend != tool::Backend::Vulkan ? 0.0f
                                        : math == DecodeMath::Int8Half                       ? 0x1p-14f
                                                                                             : 0x1p-126f;
                    const std::vector<float> actual = DecodeMip(*decoders[i], set.metadata, mip, math);
                    std::size_t different = 0;
                    for (std::size_t value = 0; value < expected.size(); ++value)
                        different += conformance::IsSame(actual[value], expected[value], flush) ? 0 : 1;
                    CHECK(different == 0);
                    ++ran;
                }
            }
        }
    }
    if (!fs::is_directory(folder))
        MESSAGE("SKIP: no conformance vectors at $OPENNTC_SHARED_DIR/conformance");
    ReportVectors("whole-mips", ran, ran == 0 ? 1 : skipped);
}
