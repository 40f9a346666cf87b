// SPDX-License-Identifier: MIT
#include "report/Device.h"

#include "Benchmark.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace openntc::report {

namespace {

class CpuDevice final : public MeasuredDevice {
public:
    explicit CpuDevice(bool quick) : record_(DescribeCpu()), quick_(quick) {}

    const DeviceRecord& GetRecord() const override { return record_; }

    std::string Prepare(const Case& c, const Encoding& encoding) override {
        constexpr DecodeMath kMaths[] = {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8,
                                         DecodeMath::FP16, DecodeMath::FP32};
        if (c.math > NTC_MATH_FP32)
            return "device or feature absent: cooperative vectors";
        if (c.sets > 0)
            return "the C++ decoders take one set at a time";
        if (c.weights != WeightsForm::Default)
            return "a form of shaders";
        if (c.outputs != Case{}.outputs)
            return "the C++ decoders always make all outputs: as 9 outputs";
        options_ = {kMaths[c.math - 1], c.linear};
        encoding_ = &encoding;
        data_ = encoding.GetData(c.math);
        data_.math = options_.math;
        decoder_ = tool::RequireDecoder(encoding.record.name, data_, {});
        return {};
    }

    bool IsSlow() const override { return true; }

    std::vector<float> Decode(int height) override {
        const int width = encoding_->record.width;
        std::vector<float> outputs(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 16);
        constexpr int kRows = 64; // between looks at Ctrl-C
        for (int y = 0; y < height; y += kRows) {
            tool::ThrowIfInterrupted();
            const int rows = std::min(kRows, height - y);
            DecodeRows(y, rows,
                       std::span(outputs).subspan(16 * static_cast<std::size_t>(y) *
                                                  static_cast<std::size_t>(width)));
        }
        return outputs;
    }

    Timing Measure() override {
        const int width = encoding_->record.width, height = encoding_->record.height;
        std::vector<float> outputs(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 16);
        const double first = DecodeRows(0, 1, outputs) / width;
        // The slow modes decode part of the image; enough rows for every thread of the fast ones.
        const double wanted = quick_ ? 0.05 : 0.15;
        const int rows =
            static_cast<int>(std::clamp(wanted / (first * width), 8.0, static_cast<double>(height)));
        std::vector<double> times;
        const int repeats = quick_ || first > 1e-5 ? 5 : 9; // the slow modes take seconds
        for (int i = 0; i < repeats; ++i) {
            tool::ThrowIfInterrupted();
            times.push_back(1e9 * DecodeRows(0, rows, outputs) / (static_cast<double>(rows) * width));
        }
        return {Summarise(times), static_cast<std::uint64_t>(rows) * static_cast<std::uint64_t>(width)};
    }

private:
    double DecodeRows(int y, int rows, std::span<float> outputs) {
        const auto start = std::chrono::steady_clock::now();
        tool::Require(decoder_->Decode(0, {0, y, encoding_->record.width, rows}, options_, outputs),
                      tool::ExitCode::Failed, encoding_->record.name);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    DeviceRecord record_;
    bool quick_;
    const Encoding* encoding_ = nullptr;
    DecodeOptions options_;
    tool::DecodeData data_;
    std::unique_ptr<tool::Decoder> decoder_;
};

} // namespace

std::unique_ptr<MeasuredDevice> MakeCpuDevice(bool quick) {
    return std::make_unique<CpuDevice>(quick);
}

DeviceRecord DescribeCpu() {
    return {tool::GetCpuName(), "C++ decoder of OpenNTC", "C++ decoder", "wall clock",
            tool::Format("%d threads for int8 and int8_half, one for the others", tool::GetCoreCount())};
}

Spread Summarise(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double fraction) {
        const double rank = fraction * static_cast<double>(values.size() - 1);
        const auto low = static_cast<std::size_t>(rank);
        const std::size_t high = std::min(low + 1, values.size() - 1);
        return std::lerp(values[low], values[high], rank - static_cast<double>(low));
    };
    if (values.empty())
        return {};
    return {at(0.5), at(0.25), at(0.75), values.front(), values.back(), static_cast<int>(values.size())};
}

} // namespace openntc::report
