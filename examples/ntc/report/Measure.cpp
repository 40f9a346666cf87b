// SPDX-License-Identifier: MIT
#include "report/Measure.h"

#include "Benchmark.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "report/Accuracy.h"
#include "report/Blocks.h"
#include "report/Cases.h"
#include "report/Device.h"
#include "report/Encodings.h"
#include "report/Filtering.h"
#include "report/Generations.h"
#include "report/Host.h"
#include "report/Pictures.h"
#include "report/Streaming.h"

#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <map>

namespace openntc::report {

using tool::CommandError;
using tool::ExitCode;
using tool::Format;

namespace {

constexpr double kPixels1080p = 1920.0 * 1080.0;
constexpr double kPixels4K = 3840.0 * 2160.0;

class Run {
public:
    explicit Run(const MeasureSettings& settings)
        : settings_(settings),
          cache_({settings.cache, settings.model, settings.steps},
                 [this](const std::string& what, double fraction) { ShowTraining(what, fraction); }) {}

    ReportRecord Execute() {
        const auto start = std::chrono::steady_clock::now();
        load_ = GetLoad();
        SelectCases();
        for (const Case& c : cases_)
            cache_.Get(c); // trained before anything is timed
        if (!streamingCases_.empty() || !blockCases_.empty() || !filteringCases_.empty())
            cache_.Get(Case{});
        OpenDevices();
        PictureMaker pictures(settings_.scratch);
        std::vector<PictureRecord> devicePictures;
        for (const std::unique_ptr<MeasuredDevice>& device : devices_)
            total_ += cases_.size() * static_cast<std::size_t>(1 + device->GetRepeats().rounds);
        total_ += streamingCases_.size() + filteringCases_.size() +
                  devices_.size() * (blockCases_.size() + sceneCases_.size() + trainingCases_.size());
        try {
            for (const std::unique_ptr<MeasuredDevice>& device : devices_)
                RunDevice(*device, pictures, devicePictures);
            CompareGenerations(report_);
            RunStreaming();
            RunBlocks();
            RunFiltering();
            RunScenes();
            RunTraining();
            report_.pictures = pictures.MakeAll(cases_, cache_, references_);
        } catch (const CommandError&) {
            if (!tool::IsInterrupted())
                throw;
            report_.cancelled = true; // minutes of work are not thrown away
            DropUntimed(report_.cases);
            DropUntimed(report_.blocks);
        }
        report_.pictures.insert(report_.pictures.end(), devicePictures.begin(), devicePictures.end());
        report_.date = GetDate();
        report_.cpu = tool::GetCpuName();
        report_.cores = tool::GetCoreCount();
        report_.load = load_;
        report_.quick = settings_.quick;
        report_.encodings = cache_.ListRecords();
        report_.cacheSeconds = cache_.GetFillSeconds();
        report_.cacheFilled = cache_.GetFilled();
        report_.trainingKernel = cache_.GetKernel();
        report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() -
                          report_.cacheSeconds;
        return std::move(report_);
    }

private:
    void SelectCases() {
        const auto isWanted = [this](const std::string& id) {
            return settings_.filters.empty() ||
                   std::any_of(
                       settings_.filters.begin(), settings_.filters.end(),
                       [&](const std::string& filter) { return id.find(filter) != std::string::npos; });
        };
        const auto select = [&](auto&& all, auto& selected) {
            for (auto& c : all) {
                if (isWanted(c.GetId()))
                    selected.push_back(std::move(c));
            }
        };
        select(ListCases(settings_.quick, cache_.GetModelMaterial()), cases_);
        select(ListStreamingCases(settings_.quick), streamingCases_);
        select(ListBlockCases(settings_.quick), blockCases_);
        select(ListFilteringCases(settings_.quick), filteringCases_);
        select(ListSceneCases(settings_.quick), sceneCases_);
        select(ListTrainingCases(settings_.quick), trainingCases_);
        if (cases_.empty() && streamingCases_.empty() && blockCases_.empty() && filteringCases_.empty() &&
            sceneCases_.empty() && trainingCases_.empty())
            throw CommandError(ExitCode::Usage, "--cases", "no case has such a name");
    }

    void OpenDevices() {
        const auto openVulkan = [this](const std::string& name) {
            devices_.push_back(
                MakeVulkanDevice({name, settings_.sources, settings_.glslang, settings_.quick}));
        };
        for (const std::string& name : settings_.devices) {
            if (name == "cpu")
                devices_.push_back(MakeCpuDevice(settings_.quick));
            else
                openVulkan(name);
        }
        if (!settings_.devices.empty())
            return;
        try {
            openVulkan("");
        } catch (const CommandError& error) {
            if (error.GetCode() != ExitCode::NoDevice)
                throw;
            Say(std::string("no Vulkan device: ") + error.what());
        }
        devices_.push_back(MakeCpuDevice(settings_.quick));
    }

    struct Pending {
        std::size_t record; ///< index in report_.cases
        std::unique_ptr<PreparedCase> prepared;
        std::vector<double> times;
    };

    void RunDevice(MeasuredDevice& device, PictureMaker& pictures,
                   std::vector<PictureRecord>& devicePictures) {
        report_.devices.push_back(device.GetRecord());
        std::vector<Pending> pending;
        for (const Case& c : cases_) {
            std::unique_ptr<PreparedCase> prepared = PrepareCase(device, c, pictures, devicePictures);
            if (prepared)
                pending.push_back({report_.cases.size() - 1, std::move(prepared), {}});
        }
        const Repeats repeats = device.GetRepeats();
        for (int round = 0; round < repeats.rounds; ++round) {
            for (Pending& p : pending) {
                const std::vector<double> times = p.prepared->Time(repeats.perRound);
                p.times.insert(p.times.end(), times.begin(), times.end());
                Advance();
            }
            Say(device.GetRecord().name + Format(": round %d of %d timed", round + 1, repeats.rounds));
        }
        for (const Pending& p : pending) {
            CaseRecord& record = report_.cases[p.record];
            record.repeats = p.times;
            record.time = Summarise(p.times);
            record.texelsPerDispatch = p.prepared->GetTexelsPerDispatch();
            record.extrapolated1080pMs = record.time.median * kPixels1080p * 1e-6;
            record.extrapolated4KMs = record.time.median * kPixels4K * 1e-6;
            Say(record.id +
                Format(": %.4g ns/texel, %.2f dB", record.time.median, record.accuracy.psnrSource));
        }
    }

    void RunStreaming() {
        for (const StreamingCase& c : streamingCases_) {
            report_.streaming.push_back(MeasureStreaming(c, cache_.Get(Case{}), settings_.quick));
            const StreamingRecord& record = report_.streaming.back();
            Say(record.id + Format(": %.1f %% at the wanted mip, %.2f dB, %.1f tiles and %.3g ms a frame",
                                   100 * record.wantedShare, record.psnr, record.tilesLoaded,
                                   record.millisecondsAFrame.median));
            Advance();
        }
    }

    void RunBlocks() {
        if (blockCases_.empty())
            return;
        const Encoding& encoding = cache_.Get(Case{});
        report_.blockSizes.push_back(MeasureBlockSizes(encoding));
        std::map<bc::BlockFormat, BlockTexture> textures;
        for (const BlockCase& c : blockCases_) {
            if (textures.count(c.format) == 0)
                textures.emplace(c.format, MakeBlockTexture(c.format, encoding, references_));
        }
        for (const std::unique_ptr<MeasuredDevice>& device : devices_)
            RunBlocksOn(*device, textures);
    }

    void RunBlocksOn(MeasuredDevice& device, const std::map<bc::BlockFormat, BlockTexture>& textures) {
        struct PendingBlocks {
            std::size_t record; // index in report_.blocks
            std::unique_ptr<PreparedBlocks> prepared;
            std::vector<double> times;
        };
        std::vector<PendingBlocks> pending;
        for (const BlockCase& c : blockCases_) {
            tool::ThrowIfInterrupted();
            const BlockTexture& texture = textures.at(c.format);
            BlockRecord skipped;
            for (std::unique_ptr<PreparedBlocks>& way : device.PrepareBlocks(c, texture, skipped.skipped)) {
                const std::vector<std::byte> expected =
                    PrepareBlocksOnCpu(c.GetSearch(), texture, 1)->Encode();
                report_.blocks.push_back(JudgeBlocks(c, texture, *way, expected));
                report_.blocks.back().device = device.GetRecord().name;
                pending.push_back({report_.blocks.size() - 1, std::move(way), {}});
            }
            if (!skipped.skipped.empty()) {
                skipped.id = c.GetId();
                skipped.device = device.GetRecord().name;
                report_.blocks.push_back(skipped);
            }
            Advance();
        }
        const Repeats repeats = device.GetRepeats();
        for (int round = 0; round < repeats.rounds; ++round) {
            for (PendingBlocks& p : pending) {
                const std::vector<double> times = p.prepared->Time(repeats.perRound);
                p.times.insert(p.times.end(), times.begin(), times.end());
            }
        }
        for (PendingBlocks& p : pending) {
            BlockRecord& record = report_.blocks[p.record];
            record.time = Summarise(std::move(p.times));
            Say(record.device + ": " + record.id +
                Format(": %.4g Mtexel/s, %.2f dB", 1e3 / record.time.median, record.psnrDecoded));
        }
    }

    void RunFiltering() {
        if (filteringCases_.empty())
            return;
        report_.filtering =
            MeasureFiltering(filteringCases_, cache_.Get(Case{}), settings_.quick, [this] { Advance(); });
        for (FilteringRecord& record : report_.filtering) {
            record.device = DescribeCpu().name;
            Say(record.id + Format(": %.2f texels, %.4g ns a sample, RMSE %.4f, %.4f of %d frames",
                                   record.texelsPerSample, record.time.median, record.rmse.front(),
                                   record.rmse.back(), record.frames.back()));
        }
    }

    void RunTraining() {
        if (trainingCases_.empty())
            return;
        const TrainingCurves curves(settings_.training, settings_.quick,
                                    [this] { return cache_.GetSource(kBricks); });
        for (const std::unique_ptr<MeasuredDevice>& device : devices_) {
            const bool isProcessor = device->GetRecord().name == DescribeCpu().name;
            for (const TrainingCase& c : trainingCases_) {
                if (c.kernel.has_value() == isProcessor) {
                    report_.training.push_back(curves.Measure(c, device->GetRecord(), device->IsSlow()));
                    Say(DescribeTraining(report_.training.back()));
                }
                Advance();
            }
        }
    }

    void RunScenes() {
        SceneSettings settings = settings_.scenes;
        settings.quick = settings_.quick;
        settings.sources = settings_.sources;
        settings.glslang = settings_.glslang;
        settings.scratch = settings_.scratch.parent_path();
        for (const std::unique_ptr<MeasuredDevice>& device : devices_) {
            SceneMeasurement measurement(settings, device->GetRecord(), device->IsSlow());
            for (const SceneCase& c : sceneCases_) {
                report_.scenes.push_back(measurement.Measure(c));
                Say(DescribeScene(report_.scenes.back()));
                Advance();
            }
        }
    }

    /// Adds the record of a case, with everything but times. Null: it is skipped.
    std::unique_ptr<PreparedCase> PrepareCase(MeasuredDevice& device, const Case& c, PictureMaker& pictures,
                                              std::vector<PictureRecord>& devicePictures) {
        tool::ThrowIfInterrupted();
        const Encoding& encoding = cache_.Get(c);
        CaseRecord record = DescribeCase(c, encoding);
        record.device = device.GetRecord().name;
        std::unique_ptr<PreparedCase> prepared = device.Prepare(c, encoding, record.skipped);
        if (prepared) {
            const std::vector<float> outputs =
                Compare(*prepared, device.IsSlow(), c, encoding, record.accuracy);
            const bool isBase = c.network == Case{}.network && c.bitsPerPixel == Case{}.bitsPerPixel &&
                                c.sets == 0 && c.outputs == Case{}.outputs && !c.linear &&
                                c.material == kBricks;
            if (isBase && record.accuracy.differentFromReference > 0)
                devicePictures.push_back(
                    pictures.MakeDevicePicture(c, encoding, record.device, outputs, references_));
            Say(record.device + ": " + record.id + ": ready");
        }
        Advance();
        report_.cases.push_back(std::move(record));
        return prepared;
    }

    /// Fills `accuracy`; returns mip 0 as the device decodes it.
    std::vector<float> Compare(PreparedCase& prepared, bool isSlow, const Case& c, const Encoding& encoding,
                               Accuracy& accuracy) {
        constexpr int kSomeRows = 16;
        const std::uint32_t mask = encoding.GetOutputMask(c.outputs);
        const std::vector<float>& reference = references_.Get(encoding, c.math, c.linear);
        int rows = isSlow ? std::min(kSomeRows, encoding.record.height) : encoding.record.height;
        std::vector<float> outputs = prepared.Decode(rows);
        std::uint64_t different = CountDifferent(outputs, reference, mask);
        if (different > 0 && rows < encoding.record.height) {
            rows = encoding.record.height;
            outputs = prepared.Decode(rows);
            different = CountDifferent(outputs, reference, mask);
        }
        const std::uint64_t compared = outputs.size() / 16 * static_cast<std::uint64_t>(std::popcount(mask));
        if (different == 0) { // as the reference, whose accuracy may be known from another device
            outputs = reference;
            Accuracy& known = known_[encoding.record.name + Format("/%d/%u/%d", c.math, mask, c.linear)];
            if (known.values == 0)
                known = MeasureAccuracy(encoding, mask, c.linear, outputs, references_);
            accuracy = known;
        } else {
            accuracy = MeasureAccuracy(encoding, mask, c.linear, outputs, references_);
        }
        accuracy.comparedWithReference = compared;
        accuracy.differentFromReference = different;
        return outputs;
    }

    void Say(const std::string& line) const {
        if (!settings_.json)
            std::fprintf(stderr, "report: %s\n", tool::Printable(line).c_str());
    }
    void ShowProgress(const char* activity, std::size_t done, std::size_t total) const {
        std::fprintf(stderr, "{\"event\":\"progress\",\"activity\":\"%s\",\"done\":%zu,\"total\":%zu}\n",
                     activity, done, total);
    }
    void ShowTraining(const std::string& what, double fraction) {
        const int percent = static_cast<int>(100 * fraction);
        if (percent / 10 == lastTenth_ && what == lastTraining_)
            return;
        lastTenth_ = percent / 10;
        lastTraining_ = what;
        if (settings_.json)
            ShowProgress("encode", static_cast<std::size_t>(percent), 100);
        else
            Say(what + Format(": %d %%", percent));
    }
    void Advance() {
        ++done_;
        if (settings_.json)
            ShowProgress("report", done_, total_);
    }

    const MeasureSettings& settings_;
    EncodingCache cache_;
    ReferenceDecodes references_;
    std::map<std::string, Accuracy> known_; // of the reference's outputs
    std::vector<Case> cases_;
    std::vector<StreamingCase> streamingCases_;
    std::vector<BlockCase> blockCases_;
    std::vector<FilteringCase> filteringCases_;
    std::vector<SceneCase> sceneCases_;
    std::vector<TrainingCase> trainingCases_;
    std::vector<std::unique_ptr<MeasuredDevice>> devices_;
    double load_ = 0;
    std::size_t done_ = 0, total_ = 0;
    std::string lastTraining_;
    int lastTenth_ = -1;
    ReportRecord report_;
};

} // namespace

ReportRecord Measure(const MeasureSettings& settings) {
    return Run(settings).Execute();
}

} // namespace openntc::report
