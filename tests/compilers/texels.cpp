// SPDX-License-Identifier: MIT
// The C++ side of tests/compilers: writes what a decoder in another process needs, and runs SPIR-V that any compiler made on
// the Vulkan device. Every number is compared with the C++ reference, bit for bit, subnormal numbers taken as zero.
//   OPENNTC_TEXELS_FOLDER   where nXmY.{constants,weights,latents,expected} and texels.json go, for network X and mode Y
//   OPENNTC_TEXELS_JOBS     file of lines: SPIR-V, network and mode, separated by tabs; JOBS.answers gets a line for each:
//                           numbers that differ, numbers compared, or "error" and why
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"
#include "support/Files.h"
#include "unit/decode/LatentMipSets.h"
#include "unit/decode/ModeSets.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr int kWidth = 36;
constexpr int kHeight = 25;
constexpr int kMips = 2;

/// The same set of a network in every run.
class Sets {
public:
    explicit Sets(int network) {
        if (network == NTC_NETWORK_GENERATION_2)
            later_ = std::make_unique<decode_test::LatentMipSet>(
                decode_test::LatentMipShape{51, network, kWidth, kHeight, 4, 4, 16});
        else if (network == NTC_NETWORK_GENERATION_3)
            later_ = std::make_unique<decode_test::LatentMipSet>(
                decode_test::LatentMipShape{52, network, kWidth, kHeight, 4, 3, 12});
        else
            first_ =
                std::make_unique<decode_test::ModeSet>(decode_test::MakeModeSet(network, kWidth, kHeight));
    }

    DecodeSource GetSource(int math) const {
        const DecodeWeights weights = GetDecodeWeights(static_cast<DecodeMath>(math));
        return first_ ? first_->GetSource(weights) : later_->GetSource(weights);
    }

private:
    std::unique_ptr<decode_test::ModeSet> first_;
    std::unique_ptr<decode_test::LatentMipSet> later_;
};

std::vector<std::uint32_t> Decode(const DecodeSource& source, int math, int mip) {
    const Rect rect = {0, 0, kWidth >> mip, kHeight >> mip};
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * NTC_MAX_CHANNELS);
    REQUIRE(DecodeReference(source, mip, rect, {.math = static_cast<DecodeMath>(math)}, outputs));
    std::vector<std::uint32_t> bits;
    for (const float value : outputs)
        bits.push_back(openntc_tests::GetDeviceBits(value));
    return bits;
}

void Write(const std::string& path, std::span<const std::byte> bytes) {
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    REQUIRE(file.good());
}

struct Job {
    std::string path;
    int network = 0, math = 0;
};

struct Difference {
    std::size_t different = 0, compared = 0;
};

Expected<Difference> Run(Context& context, const Job& job, const DecodeSource& source) {
    const std::vector<std::byte> bytes = openntc_tests::ReadBytes(job.path);
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    // As shaders/Texels.hlsl and Texels.comp say.
    const BufferSlot slots[] = {{0, BufferKind::Uniform},
                                {1, BufferKind::Storage},
                                {2, BufferKind::Storage},
                                {3, BufferKind::Storage},
                                {4, BufferKind::Uniform}};
    OPENNTC_ASSIGN(const ComputePipeline pipeline,
                   context.CreateComputePipeline(words, slots, 0, {.isKept = false}));
    const auto create = [&](std::span<const std::byte> data, BufferKind kind) {
        return context.CreateBuffer(data, kind, BufferMemory::HostVisible);
    };
    OPENNTC_ASSIGN(const Buffer constants,
                   create(std::as_bytes(std::span(source.constants, 1)), BufferKind::Uniform));
    OPENNTC_ASSIGN(const Buffer latents, create(source.latents, BufferKind::Storage));
    OPENNTC_ASSIGN(const Buffer weights, create(source.weights, BufferKind::Storage));
    Difference sum;
    for (int mip = 0; mip < kMips; ++mip) {
        const std::uint32_t width = kWidth >> mip, height = kHeight >> mip;
        const std::uint32_t texels[] = {width, height, static_cast<std::uint32_t>(mip), 0};
        OPENNTC_ASSIGN(const Buffer request, create(std::as_bytes(std::span(texels)), BufferKind::Uniform));
        OPENNTC_ASSIGN(const Buffer results,
                       context.CreateBuffer(std::uint64_t{width} * height * 4 * NTC_MAX_CHANNELS,
                                            BufferKind::Storage, BufferMemory::HostVisible));
        const BoundBuffer bound[] = {
            {0, &constants}, {1, &latents}, {2, &weights}, {3, &results}, {4, &request}};
        OPENNTC_CHECK(context.Dispatch({&pipeline, bound, {}, {(width * height + 63) / 64, 1, 1}}));
        std::vector<std::uint32_t> outputs(std::size_t{width} * height * NTC_MAX_CHANNELS);
        OPENNTC_CHECK(context.Read(results, 0, std::as_writable_bytes(std::span(outputs))));
        const std::vector<std::uint32_t> expected = Decode(source, job.math, mip);
        for (std::size_t i = 0; i < outputs.size(); ++i)
            sum.different += openntc_tests::GetDeviceBits(outputs[i]) != expected[i] ? 1 : 0;
        sum.compared += outputs.size();
    }
    return sum;
}

} // namespace

TEST_CASE("what a decoder in another process needs") {
    const char* folder = std::getenv("OPENNTC_TEXELS_FOLDER");
    if (folder == nullptr) {
        MESSAGE("SKIP: OPENNTC_TEXELS_FOLDER is not set; tests/compilers/run.sh sets it");
        return;
    }
    for (int network = NTC_NETWORK_SMALL; network <= NTC_NETWORK_GENERATION_3; ++network) {
        const Sets sets(network);
        for (int math = NTC_MATH_INT8; math <= NTC_MATH_FP32; ++math) {
            const DecodeSource source = sets.GetSource(math);
            const std::string stem =
                std::string(folder) + "/n" + std::to_string(network) + "m" + std::to_string(math);
            Write(stem + ".constants", std::as_bytes(std::span(source.constants, 1)));
            Write(stem + ".weights", source.weights);
            Write(stem + ".latents", source.latents);
            std::vector<std::uint32_t> expected;
            for (int mip = 0; mip < kMips; ++mip) {
                const std::vector<std::uint32_t> bits = Decode(source, math, mip);
                expected.insert(expected.end(), bits.begin(), bits.end());
            }
            Write(stem + ".expected", std::as_bytes(std::span(expected)));
        }
    }
    std::ofstream(std::string(folder) + "/texels.json")
        << "{\"width\": " << kWidth << ", \"height\": " << kHeight << ", \"mips\": " << kMips << "}\n";
}

TEST_CASE("SPIR-V on the device against the reference") {
    const char* path = std::getenv("OPENNTC_TEXELS_JOBS");
    if (path == nullptr) {
        MESSAGE("SKIP: OPENNTC_TEXELS_JOBS is not set; tests/compilers/run.sh sets it");
        return;
    }
    OPENNTC_REQUIRE_DEVICE(context);
    std::ifstream jobs(path);
    REQUIRE(jobs.good());
    std::ofstream answers(std::string(path) + ".answers");
    std::unique_ptr<Sets> sets;
    int network = 0;
    for (std::string line; std::getline(jobs, line);) {
        std::istringstream fields(line);
        Job job;
        std::getline(fields, job.path, '\t');
        REQUIRE((fields >> job.network >> job.math));
        if (job.network != network)
            sets = std::make_unique<Sets>(job.network);
        network = job.network;
        const Expected<Difference> result = Run(*context, job, sets->GetSource(job.math));
        if (result)
            answers << result->different << '\t' << result->compared << std::endl;
        else
            answers << "error\t" << result.error().GetText() << std::endl;
    }
}
