// SPDX-License-Identifier: MIT
#include "report/Accuracy.h"

#include "Failure.h"
#include "Interrupt.h"
#include "encode/ComparedSet.h"

#include "openntc/MathModes.h"
#include "openntc/decode/ShaderMath.h"
#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <thread>

namespace openntc::report {

namespace {

/// The channels of `mask` that textures cover, as planes.
tool::ComparedSet::Mip MakePlanes(const Encoding& encoding, std::uint32_t mask,
                                  std::span<const float> outputs) {
    tool::ComparedSet::Mip mip;
    mip.width = encoding.record.width;
    mip.height = encoding.record.height;
    for (std::size_t c = 0; c < 16; ++c) {
        if ((mask >> c & 1u) == 0)
            continue;
        mip.planes[c].resize(outputs.size() / 16);
        for (std::size_t i = 0; i < mip.planes[c].size(); ++i)
            mip.planes[c][i] = outputs[16 * i + c];
    }
    return mip;
}

struct Distance {
    double psnr = 0, ssim = 0, worstLsb = 0;
};

Distance MeasureDistance(const tool::ComparedSet::Mip& a, const tool::ComparedSet::Mip& b,
                         std::uint32_t mask) {
    tool::ChannelDifference sum;
    double ssim = 0;
    for (int c = 0; c < 16; ++c) {
        if ((mask >> c & 1u) == 0)
            continue;
        sum.Add(tool::CompareChannel(a, b, c));
        ssim += tool::MeasureSsim(a, b, c);
    }
    return {sum.Psnr(), ssim / std::popcount(mask), 255.0 * static_cast<double>(sum.worst)};
}

} // namespace

std::vector<float> DecodeOnCpu(const Encoding& encoding, int math, bool linear) {
    const DecodeMath mode = GetDecodeMath(math);
    tool::DecodeData data = encoding.GetData(math);
    data.math = mode;
    const std::unique_ptr<tool::Decoder> decoder = tool::RequireDecoder(encoding.record.name, data, {});
    const int width = encoding.record.width, height = encoding.record.height;
    std::vector<float> outputs(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 16);
    constexpr int kRows = 8;
    std::atomic<int> next{0};
    std::atomic<bool> failed{false};
    // Most maths modes have a decoder of one thread only; decoders may be used from several.
    const auto work = [&] {
        for (int y = kRows * next++; y < height && !tool::IsInterrupted(); y = kRows * next++) {
            const int rows = std::min(kRows, height - y);
            const std::size_t row = 16 * static_cast<std::size_t>(width);
            const std::span<float> band = std::span(outputs).subspan(row * static_cast<std::size_t>(y),
                                                                     row * static_cast<std::size_t>(rows));
            if (!decoder->Decode(0, {0, y, width, rows}, {mode, linear}, band))
                failed = true;
        }
    };
    std::vector<std::thread> threads;
    for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i)
        threads.emplace_back(work);
    work();
    for (std::thread& thread : threads)
        thread.join();
    tool::ThrowIfInterrupted();
    if (failed)
        throw tool::CommandError(tool::ExitCode::Failed, encoding.record.name, "decoding: failed");
    return outputs;
}

const std::vector<float>& ReferenceDecodes::Get(const Encoding& encoding, int math, bool linear) {
    math = static_cast<int>(GetDecodeMath(math)); // whose numbers are those of the shader's modes
    std::vector<float>& outputs =
        kept_[encoding.record.name + "/" + GetMathName(math) + (linear ? "/linear" : "/stored")];
    if (outputs.empty())
        outputs = DecodeOnCpu(encoding, math, linear);
    return outputs;
}

std::uint64_t CountDifferent(std::span<const float> outputs, std::span<const float> reference,
                             std::uint32_t mask) {
    std::uint64_t different = 0;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if ((mask >> (i % 16) & 1u) != 0)
            different +=
                std::bit_cast<std::uint32_t>(outputs[i]) != std::bit_cast<std::uint32_t>(reference[i]);
    }
    return different;
}

Accuracy MeasureAccuracy(const Encoding& encoding, std::uint32_t mask, bool linear,
                         std::span<const float> outputs, ReferenceDecodes& references) {
    const encode::Material& material = encoding.source->material;
    const std::uint32_t compared = mask & material.GetDeclaredChannels();
    const std::vector<float>& fp32 = references.Get(encoding, NTC_MATH_FP32, linear);
    const tool::ComparedSet::Mip decoded = MakePlanes(encoding, compared, outputs);
    tool::ComparedSet::Mip source;
    source.width = decoded.width;
    source.height = decoded.height;
    for (int c = 0; c < 16; ++c) {
        const std::span<const float> plane = material.GetPlane(0, c);
        source.planes[c].assign(plane.begin(), plane.end());
        const auto space = static_cast<ColorSpace>(material.GetChannelColorSpaces() >> (2 * c) & 3u);
        if (linear) {
            for (float& value : source.planes[c])
                value = image::DecodeColor(space, value);
        }
    }
    const Distance toSource = MeasureDistance(decoded, source, compared);
    const Distance toFp32 = MeasureDistance(decoded, MakePlanes(encoding, compared, fp32), compared);
    Accuracy accuracy{toSource.psnr, toSource.ssim, toSource.worstLsb,
                      toFp32.psnr,   toFp32.ssim,   toFp32.worstLsb};
    std::vector<double> errors;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        if ((compared >> (i % 16) & 1u) == 0)
            continue;
        errors.push_back(255.0 * std::fabs(static_cast<double>(outputs[i]) - static_cast<double>(fp32[i])));
    }
    accuracy.values = errors.size();
    const auto at = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() * 99 / 100);
    std::nth_element(errors.begin(), at, errors.end());
    accuracy.percentile99LsbFp32 = *at;
    return accuracy;
}

} // namespace openntc::report
