// SPDX-License-Identifier: MIT
#include "report/Device.h"

#include "Benchmark.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "encode/TrainingProgress.h"

#include "openntc/MathModes.h"
#include "openntc/core/ThreadTeam.h"

#include <algorithm>
#include <chrono>

namespace openntc::report {

namespace {

class CpuCase final : public PreparedCase {
public:
    CpuCase(const Case& c, const Encoding& encoding, DecodeOptions options,
            const tool::BackendOptions& backend, bool quick)
        : record_(encoding.record), options_(options), quick_(quick), isOneThread_(backend.threads == 1),
          data_(encoding.GetData(c.math)) {
        data_.math = options.math;
        decoder_ = tool::RequireDecoder(record_.name, data_, backend);
    }

    std::vector<float> Decode(int height) override {
        std::vector<float> outputs(CountFloats(height));
        constexpr int kRows = 64; // between looks at Ctrl-C
        for (int y = 0; y < height; y += kRows) {
            tool::ThrowIfInterrupted();
            DecodeRows(y, std::min(kRows, height - y), std::span(outputs).subspan(CountFloats(y)));
        }
        return outputs;
    }

    std::vector<double> Time(int repeats) override {
        outputs_.resize(CountFloats(record_.height));
        const double first = DecodeRows(0, 8, outputs_) / 8;
        // The slow modes decode part of the image; enough rows for every thread of the fast ones.
        const double wanted = quick_ ? 0.05 : 0.1;
        rows_ = static_cast<int>(std::clamp(wanted / first, 8.0, static_cast<double>(record_.height)));
        std::vector<double> times;
        for (int i = 0; i < repeats; ++i) {
            tool::ThrowIfInterrupted();
            times.push_back(1e9 * DecodeRows(0, rows_, outputs_) /
                            static_cast<double>(GetTexelsPerDispatch()));
        }
        return times;
    }

    std::uint64_t GetTexelsPerDispatch() const override {
        return static_cast<std::uint64_t>(rows_) * static_cast<std::uint64_t>(record_.width);
    }

private:
    std::size_t CountFloats(int rows) const {
        return 16 * static_cast<std::size_t>(rows) * static_cast<std::size_t>(record_.width);
    }
    /// Seconds: of the clock, of one thread the processor's, which other work disturbs less.
    double DecodeRows(int y, int rows, std::span<float> outputs) {
        const auto start = std::chrono::steady_clock::now();
        const double processor = tool::GetProcessorSeconds();
        tool::Require(decoder_->Decode(0, {0, y, record_.width, rows}, options_, outputs),
                      tool::ExitCode::Failed, record_.name);
        const double ownSeconds = isOneThread_ ? tool::GetProcessorSeconds() - processor : 0.0;
        return ownSeconds > 0.0
                   ? ownSeconds
                   : std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    }

    const EncodingRecord& record_;
    DecodeOptions options_;
    bool quick_;
    bool isOneThread_;
    tool::DecodeData data_;
    std::unique_ptr<tool::Decoder> decoder_;
    std::vector<float> outputs_;
    int rows_ = 0;
};

class CpuDevice final : public MeasuredDevice {
public:
    explicit CpuDevice(bool quick) : record_(DescribeCpu()), quick_(quick) {}

    const DeviceRecord& GetRecord() const override { return record_; }
    bool IsSlow() const override { return true; }
    Repeats GetRepeats() const override { return quick_ ? Repeats{5, 1} : Repeats{7, 1}; }

    std::unique_ptr<PreparedCase> Prepare(const Case& c, const Encoding& encoding,
                                          std::string& skipped) override {
        constexpr DecodeMath kMaths[] = {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8,
                                         DecodeMath::FP16, DecodeMath::FP32};
        if (UsesMatrices(c.math))
            skipped = "device or feature absent: cooperative matrices";
        else if (c.math > NTC_MATH_FP32)
            skipped = "device or feature absent: cooperative vectors";
        else if (c.latentTexture)
            skipped = "a form of shaders: latents in a texture";
        else if (c.sets > 0)
            skipped = "the C++ decoders take one set at a time";
        else if (c.weights != WeightsForm::Default)
            skipped = "a form of shaders";
        else if (c.outputs != Case{}.outputs)
            skipped = "the C++ decoders always make all outputs: as 9 outputs";
        else if (encoding.record.height < 8)
            skipped = "the image has fewer than 8 rows";
        tool::BackendOptions backend;
        if (c.instructions > 0) {
            backend.simd = tool::ListSimdTargets()[static_cast<std::size_t>(c.instructions - 1)].first;
            backend.threads = 1;
            if (!tool::MakeDecoder(encoding.GetData(c.math), backend))
                skipped = "device or feature absent: instructions of the processor";
        }
        if (!skipped.empty())
            return nullptr;
        return std::make_unique<CpuCase>(c, encoding, DecodeOptions{kMaths[c.math - 1], c.linear}, backend,
                                         quick_);
    }

    std::vector<std::unique_ptr<PreparedBlocks>>
    PrepareBlocks(const BlockCase& c, const BlockTexture& texture, std::string&) override {
        std::vector<std::unique_ptr<PreparedBlocks>> ways;
        ways.push_back(PrepareBlocksOnCpu(c, texture, 1));
        if (const int all = CountHardwareThreads(); all > 1)
            ways.push_back(PrepareBlocksOnCpu(c, texture, all));
        return ways;
    }

private:
    DeviceRecord record_;
    bool quick_;
};

} // namespace

std::unique_ptr<MeasuredDevice> MakeCpuDevice(bool quick) {
    return std::make_unique<CpuDevice>(quick);
}

DeviceRecord DescribeCpu() {
    return {tool::GetCpuName(), "C++ decoder of OpenNTC", "C++ decoder", "wall clock",
            tool::Format("%d threads for int8 and int8_half, one for the others", tool::GetCoreCount())};
}

} // namespace openntc::report
