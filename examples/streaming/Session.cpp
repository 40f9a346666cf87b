// SPDX-License-Identifier: MIT
#include "Session.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Pictures.h"
#include "Progress.h"
#include "StreamedLandscape.h"
#include "Verification.h"

#include <chrono>
#include <cstdio>
#include <cstring>

namespace openntc::landscape {

using tool::CommandError;
using tool::ExitCode;
using tool::Format;
using tool::Require;

namespace {

LandscapeScene MakeFrame(const Landscape& landscape, const SessionOptions& options, int frame) {
    const double time = options.frames > 1 ? static_cast<double>(frame) / (options.frames - 1) : 0.5;
    return MakeScene(landscape, time, options.width * options.samples, options.height * options.samples,
                     static_cast<std::uint32_t>(frame));
}

std::uint64_t CountDifferences(const Picture& a, const Picture& b) {
    std::uint64_t different = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        if (a.colors[i] != b.colors[i] ||
            std::memcmp(&a.pixels[i], &b.pixels[i], sizeof(LandscapePixel)) != 0)
            ++different;
    }
    return different;
}

/// Frames and what is done with each.
class Session {
public:
    Session(harness::Context& context, const SessionOptions& options)
        : options_(options), landscape_(options.landscape), streamed_(context, landscape_, options),
          folder_(options.output), pixels_(static_cast<std::uint64_t>(options.width * options.height) *
                                           static_cast<std::uint64_t>(options.samples * options.samples)) {
        if (options.compares) {
            resident_.emplace(context, landscape_, pixels_, nullptr, 0);
            report_.comparison.emplace();
        }
    }

    Report Run(const harness::DeviceInfo& device) {
        const auto start = std::chrono::steady_clock::now();
        report_.device = device.name;
        report_.driver = device.driver;
        report_.landscape = options_.landscape;
        report_.width = options_.width;
        report_.height = options_.height;
        report_.texels = landscape_.GetTexels();
        report_.tiles = landscape_.GetTileCount();
        report_.allResidentBytes = landscape_.GetLatentBytes();
        report_.blockCompressedBytes = landscape_.GetBlockBytes();
        streamed_.Describe(report_);
        {
            tool::Progress progress("frames", static_cast<std::uint64_t>(options_.frames), options_.json);
            for (int frame = 0; frame < options_.frames; ++frame) {
                RunFrame(frame);
                progress.Advance(1);
            }
        }
        report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        WriteTimeline();
        return std::move(report_);
    }

private:
    void RunFrame(int frame) {
        const LandscapeScene scene = MakeFrame(landscape_, options_, frame);
        FrameRecord record = streamed_.DrawFrame(scene);
        const Picture picture = streamed_.GetRenderer().ReadPicture(pixels_);
        if (options_.check > 0) {
            const bool isLast = frame + 1 == options_.frames;
            const Check check = CheckPixels(landscape_, picture.pixels,
                                            isLast ? 1 : static_cast<std::size_t>(options_.check));
            record.checkedTexels = check.texels;
            record.wrongTexels = check.wrong;
        }
        if (resident_ && record.isComplete) { // others show coarser mips where tiles are missing
            resident_->Draw(scene);
            report_.comparison->pixels += pixels_;
            report_.comparison->differentPixels += CountDifferences(picture, resident_->ReadPicture(pixels_));
        }
        report_.frames.push_back(record);
        report_.files.push_back(Format("frame-%04d.png", frame));
        WriteFramePng(folder_.Stage(report_.files.back()), picture, options_.width, options_.height,
                      options_.samples);
        report_.files.push_back(Format("residency-%04d.png", frame));
        const double fieldSize = static_cast<double>(scene.fieldSize);
        WriteResidencyPng(folder_.Stage(report_.files.back()), landscape_,
                          streamed_.GetLoader().GetPageTable(), streamed_.GetTextureIds(),
                          static_cast<double>(scene.eye[0]) / fieldSize,
                          static_cast<double>(scene.eye[2]) / fieldSize);
    }

    void WriteTimeline() {
        report_.files.push_back("timeline.json");
        const std::filesystem::path json = folder_.Stage(report_.files.back());
        try {
            const std::string plot = DrawTimeline(report_, json.parent_path());
            report_.files.push_back("timeline.svg");
            tool::WriteBytes(folder_.Stage(report_.files.back()), plot);
        } catch (const CommandError& error) { // the numbers are there without it
            if (error.GetCode() != ExitCode::NoDevice)
                throw;
            std::fprintf(stderr, "streaming: warning: %s\n", tool::Printable(error.what()).c_str());
        }
        tool::WriteBytes(json, MakeJson(report_));
        tool::ThrowIfInterrupted();
        folder_.Commit();
    }

    const SessionOptions& options_;
    Landscape landscape_;
    StreamedLandscape streamed_;
    tool::OutputFolder folder_;
    std::uint64_t pixels_;
    std::optional<Renderer> resident_;
    Report report_;
};

} // namespace

Report RunSession(const SessionOptions& options) {
    harness::ContextOptions contextOptions;
    contextOptions.device = options.device;
    const std::unique_ptr<harness::Context> context =
        Require(harness::Context::Create(contextOptions), ExitCode::NoDevice, "device");
    Session session(*context, options);
    return session.Run(context->GetDevice());
}

} // namespace openntc::landscape
