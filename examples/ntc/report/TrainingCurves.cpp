// SPDX-License-Identifier: MIT
#include "report/TrainingCurves.h"

#include "Interrupt.h"
#include "Output.h"
#include "encode/DeviceTraining.h"
#include "encode/EncodeInputs.h"
#include "encode/Training.h"
#include "encode/TrainingProgress.h"

#include "openntc/encode/Kernels.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <filesystem>

namespace openntc::report {

using tool::Format;

namespace {

constexpr double kSeconds = 3.0, kQuickSeconds = 0.2;
constexpr int kFirstSteps = 64, kFirstSlowSteps = 1;
constexpr std::size_t kMostPoints = 24;
constexpr float kBitsPerPixel = 4.0f;
constexpr std::uint32_t kCurveSeed = 1;

std::shared_ptr<const Source> LoadSource(const std::string& manifest) {
    tool::InputOptions options;
    options.paths = {manifest};
    tool::EncodeInputs inputs = tool::LoadInputs(options);
    return std::make_shared<Source>(
        Source{std::move(inputs.material), inputs.lossScales, inputs.maskChannel, 0});
}

} // namespace

std::string TrainingCase::GetId() const {
    return std::string("training: ") + (kernel ? encode::KernelToString(*kernel) : "device");
}

std::vector<TrainingCase> ListTrainingCases(bool quick) {
    std::vector<TrainingCase> cases;
    for (const encode::KernelChoice kernel : encode::kKernels) {
        if (encode::IsKernelAvailable(kernel) && (!quick || cases.empty()))
            cases.push_back({kernel});
    }
    cases.push_back({});
    return cases;
}

TrainingCurves::TrainingCurves(const TrainingSettings& settings, bool quick,
                               const std::function<std::shared_ptr<const Source>()>& material)
    : settings_(settings),
      name_(settings.manifest.empty() ? kBricks : std::filesystem::path(settings.manifest).stem().string()),
      source_(settings.manifest.empty() ? material() : LoadSource(settings.manifest)) {
    if (!(settings_.seconds > 0.0))
        settings_.seconds = quick ? kQuickSeconds : kSeconds;
}

TrainingRecord TrainingCurves::Measure(const TrainingCase& c, const DeviceRecord& device, bool isSlow) const {
    TrainingRecord record;
    record.id = c.GetId();
    record.device = device.name;
    record.material = name_;
    record.width = source_->material.GetWidth();
    record.height = source_->material.GetHeight();
    record.channels = std::popcount(source_->material.GetDeclaredChannels());
    record.bitsPerPixel = kBitsPerPixel;
    record.threads = c.kernel ? 1 : 0;
    encode::EncodeOptions options;
    options.bitsPerPixel = kBitsPerPixel;
    options.seed = kCurveSeed;
    options.lossScales = source_->lossScales;
    options.maskChannel = source_->maskChannel;
    options.threads = record.threads;
    options.kernel = c.kernel.value_or(encode::KernelChoice::Best);
    if (!c.kernel && settings_.batchTexels > 0)
        options.batchTexels = settings_.batchTexels;
    options.steps = static_cast<std::uint64_t>(isSlow && !c.kernel ? kFirstSlowSteps : kFirstSteps);
    const auto goesOn = [](const encode::Progress&) { return !tool::IsInterrupted(); };
    for (double seconds = 0.0; seconds < settings_.seconds && record.steps.size() < kMostPoints;
         options.steps *= 2) {
        const auto start = std::chrono::steady_clock::now();
        const double processor = tool::GetProcessorSeconds();
        const Expected<encode::EncodeResult> result =
            c.kernel ? tool::Train(source_->material, options, goesOn)
                     : tool::TrainOnVulkan(device.name, source_->material, options, goesOn);
        tool::ThrowIfInterrupted();
        if (!result) {
            record.skipped = result.error().GetText();
            return record;
        }
        record.kernel = result->kernel;
        record.batchTexels = result->batchTexels;
        record.steps.push_back(static_cast<int>(options.steps));
        record.seconds.push_back(
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        record.processorSeconds.push_back(std::max(tool::GetProcessorSeconds() - processor, 0.0));
        // Other work on the machine lengthens only the clock's.
        const bool isOwn = c.kernel && record.processorSeconds.back() > 0.0;
        seconds = isOwn ? record.processorSeconds.back() : record.seconds.back();
        record.psnr.push_back(result->psnr);
    }
    return record;
}

std::string DescribeTraining(const TrainingRecord& record) {
    if (record.steps.empty())
        return record.id + ": " + record.skipped;
    return record.id + (record.threads > 0 ? "" : ", " + record.device) +
           Format(": %d steps, %.2f s, %.2f dB", record.steps.back(), record.seconds.back(),
                  record.psnr.back());
}

} // namespace openntc::report
