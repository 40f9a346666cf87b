// SPDX-License-Identifier: MIT
// `ntc compare`: how much two texture sets, or a set and its source images, differ.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "FileNames.h"
#include "Flip.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Png.h"
#include "Progress.h"
#include "encode/ComparedSet.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <tuple>

namespace openntc::tool {

namespace {

struct CompareOptions {
    std::string first;
    std::string second;
    std::string images;
    double minPsnr = 0.0; ///< > 0: less is a failure
    bool discardMasked = false;
    bool flip = false;
    bool json = false;
};

class CompareCommand {
public:
    explicit CompareCommand(const CompareOptions& options) : options_(options) {
        std::tie(a_, b_) = LoadComparedSets(options.first, options.second);
        if (a_.mips[0].width != b_.mips[0].width || a_.mips[0].height != b_.mips[0].height)
            throw CommandError(ExitCode::Failed, options.second,
                               Format("size: %d x %d: %s has %d x %d", b_.mips[0].width, b_.mips[0].height,
                                      options.first.c_str(), a_.mips[0].width, a_.mips[0].height));
        pairs_ = PairChannels(a_, b_);
        for (const int mask : {a_.maskChannel, b_.maskChannel}) {
            if (mask >= 0) {
                ClampChannel(a_, mask);
                ClampChannel(b_, mask);
                mask_ = mask;
            }
        }
        if (options.discardMasked && mask_ < 0)
            throw CommandError(ExitCode::Usage, "--discard-masked",
                               "neither side is a manifest that names a mask");
        mips_ = std::min(a_.mips.size(), b_.mips.size());
        if (pairs_.channels == 0)
            throw CommandError(ExitCode::Failed, options.second, "channels: none in common");
    }

    int Run() {
        for (const ComparedSet* side : {&a_, &b_}) {
            for (const std::string& warning : side->warnings)
                PrintWarning(warning, options_.json);
        }
        Measure();
        if (!options_.images.empty())
            WriteImages();
        if (options_.json)
            PrintJson();
        else
            Print();
        FinishOutput();
        if (total_.Psnr() < options_.minPsnr)
            throw CommandError(ExitCode::Failed, "--min-psnr",
                               Format("%.4f dB: less than %g", total_.Psnr(), options_.minPsnr));
        return 0;
    }

private:
    /// The mask of the side that names one, where its texels count for a channel.
    std::span<const float> GetMask(std::size_t mip, int channel) const {
        if (!options_.discardMasked || channel == mask_)
            return {};
        return (a_.maskChannel >= 0 ? a_ : b_).mips[mip].planes[mask_];
    }

    bool HasChannel(int channel) const { return (pairs_.channels >> channel & 1u) != 0; }

    void Measure() {
        table_.resize(mips_);
        for (std::size_t m = 0; m < mips_; ++m) {
            for (int c = 0; c < 16; ++c) {
                if (!HasChannel(c))
                    continue;
                const ChannelDifference difference = CompareChannel(a_.mips[m], b_.mips[m], c, GetMask(m, c));
                table_[m].channels[c] = difference;
                table_[m].all.Add(difference);
                perChannel_[c].Add(difference);
                total_.Add(difference);
                if (difference.worst > worst_) {
                    worst_ = difference.worst;
                    worstMip_ = m;
                    worstChannel_ = c;
                }
            }
        }
        for (int c = 0; c < 16; ++c)
            ssim_[c] = HasChannel(c) ? MeasureSsim(a_.mips[0], b_.mips[0], c, GetMask(0, c)) : 0.0;
    }
    ChannelDifference SumTexture(const ComparedTexture& texture) const {
        ChannelDifference sum;
        for (int c = texture.firstChannel; c < texture.firstChannel + texture.channels; ++c) {
            if (HasChannel(c))
                sum.Add(perChannel_[c]);
        }
        return sum;
    }
    double AverageSsim(const ComparedTexture& texture) const {
        double sum = 0.0, count = 0.0;
        for (int c = texture.firstChannel; c < texture.firstChannel + texture.channels; ++c) {
            sum += ssim_[c];
            count += HasChannel(c) ? 1.0 : 0.0;
        }
        return sum / count;
    }
    /// FLIP of a texture's first three channels as sRGB, mip 0; nullopt for textures that have fewer in common.
    std::optional<FlipResult> MeasureFlip(const ComparedTexture& texture) const {
        if (!options_.flip || texture.channels < 3 || (pairs_.channels >> texture.firstChannel & 7u) != 7u)
            return std::nullopt;
        const ComparedSet::Mip &a = a_.mips[0], &b = b_.mips[0];
        return ComputeFlip(InterleaveColors(a, texture.firstChannel),
                           InterleaveColors(b, texture.firstChannel), a.width, a.height);
    }

    void PrintLeftOut(const ComparedSet& side, const ComparedPairs::LeftOut& left) const {
        const std::string note = "note: only in " + Printable(side.path) + ", not compared: ";
        if (!left.text.empty())
            WriteOutput(note + left.text + "\n");
        if (side.mips.size() > mips_)
            WriteOutput(note + "mips " + std::to_string(mips_) + " to " +
                        std::to_string(side.mips.size() - 1) + "\n");
    }
    void WriteLeftOut(JsonWriter& json, const char* key, const ComparedSet& side,
                      const ComparedPairs::LeftOut& left) const {
        json.Key(key);
        json.BeginObject();
        json.Key("textures");
        json.BeginArray();
        for (const std::string& texture : left.textures)
            json.Value(std::string_view(texture));
        json.EndArray();
        json.Key("channels");
        json.BeginArray();
        for (const int channel : left.channels)
            json.Value(channel);
        json.EndArray();
        json.Member("mips", static_cast<int>(side.mips.size() - mips_));
        json.EndObject();
    }

    void Print() const {
        WriteOutput(Format("psnr %.4f dB\n", total_.Psnr()));
        if (!pairs_.isByName)
            WriteOutput("note: no texture has the same name on both sides: compared by channel\n");
        PrintLeftOut(a_, pairs_.onlyInA);
        PrintLeftOut(b_, pairs_.onlyInB);
        for (const ComparedTexture& texture : pairs_.textures) {
            const std::optional<FlipResult> flip = MeasureFlip(texture);
            WriteOutput(
                Format("texture %s: psnr %.4f dB, ssim %.5f%s\n", Printable(texture.name).c_str(),
                       SumTexture(texture).Psnr(), AverageSsim(texture),
                       flip ? Format(", flip %.5f, at most %.5f", flip->mean, flip->maximum).c_str() : ""));
        }
        for (int c = 0; c < 16; ++c) {
            if (HasChannel(c))
                WriteOutput(
                    Format("channel %d: psnr %.4f dB, ssim %.5f\n", c, perChannel_[c].Psnr(), ssim_[c]));
        }
        for (std::size_t m = 0; m < mips_; ++m)
            WriteOutput(Format("mip %zu: psnr %.4f dB\n", m, table_[m].all.Psnr()));
        const ChannelDifference& worst = table_[worstMip_].channels[worstChannel_];
        WriteOutput(Format("worst: mip %zu, texel %d %d, channel %d: %.9g\n", worstMip_, worst.worstX,
                           worst.worstY, worstChannel_, static_cast<double>(worst.worst)));
    }
    void PrintJson() const {
        JsonWriter json;
        json.BeginObject();
        json.Member("psnr", total_.Psnr());
        json.Member("pairing", std::string_view(pairs_.isByName ? "name" : "channel"));
        WriteLeftOut(json, "onlyInA", a_, pairs_.onlyInA);
        WriteLeftOut(json, "onlyInB", b_, pairs_.onlyInB);
        json.Key("textures");
        json.BeginArray();
        for (const ComparedTexture& texture : pairs_.textures) {
            json.BeginObject();
            json.Member("name", std::string_view(texture.name));
            json.Member("psnr", SumTexture(texture).Psnr());
            json.Member("ssim", AverageSsim(texture));
            if (const std::optional<FlipResult> flip = MeasureFlip(texture)) {
                json.Key("flip");
                json.BeginObject();
                json.Member("mean", flip->mean);
                json.Member("maximum", flip->maximum);
                json.EndObject();
            }
            json.EndObject();
        }
        json.EndArray();
        json.Key("channels");
        json.BeginArray();
        for (int c = 0; c < 16; ++c) {
            if (!HasChannel(c))
                continue;
            json.BeginObject();
            json.Member("channel", c);
            json.Member("psnr", perChannel_[c].Psnr());
            json.Member("ssim", ssim_[c]);
            json.EndObject();
        }
        json.EndArray();
        json.Key("mips");
        json.BeginArray();
        for (std::size_t m = 0; m < mips_; ++m)
            json.Value(table_[m].all.Psnr());
        json.EndArray();
        const ChannelDifference& worst = table_[worstMip_].channels[worstChannel_];
        json.Key("worst");
        json.BeginObject();
        json.Member("mip", static_cast<int>(worstMip_));
        json.Member("x", worst.worstX);
        json.Member("y", worst.worstY);
        json.Member("channel", worstChannel_);
        json.Member("difference", worst.worst);
        json.EndObject();
        json.EndObject();
        WriteOutput(json.Take());
    }

    /// NAME.png: first, second and their difference times 8, side by side, mip 0.
    void WriteImages() const {
        OutputFolder folder(options_.images);
        FileNames names;
        constexpr float kAmplification = 8.0f;
        const ComparedSet::Mip &a = a_.mips[0], &b = b_.mips[0];
        for (const ComparedTexture& texture : pairs_.textures) {
            const int shown = texture.channels >= 3 ? 3 : 1;
            const std::string name = names.Add(texture.name) + ".png";
            PngWriter png(folder.Stage(name), name, {3 * a.width, a.height, shown, 8});
            std::vector<std::uint16_t> row(static_cast<std::size_t>(3 * a.width * shown));
            for (int y = 0; y < a.height; ++y) {
                std::size_t at = 0;
                for (int part = 0; part < 3; ++part) {
                    for (int x = 0; x < a.width; ++x) {
                        const std::size_t i =
                            static_cast<std::size_t>(y) * static_cast<std::size_t>(a.width) +
                            static_cast<std::size_t>(x);
                        for (int c = 0; c < shown; ++c) {
                            const int channel = texture.firstChannel + c;
                            float value = 0.0f;
                            if (HasChannel(channel)) {
                                const float va = a.planes[channel][i], vb = b.planes[channel][i];
                                value = part == 0 ? va : part == 1 ? vb : std::fabs(va - vb) * kAmplification;
                            }
                            row[at++] = static_cast<std::uint16_t>(
                                std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
                        }
                    }
                }
                png.WriteRow(row);
            }
            png.Finish();
        }
        folder.Commit();
    }

    struct MipTable {
        ChannelDifference channels[16];
        ChannelDifference all;
    };

    const CompareOptions& options_;
    ComparedSet a_, b_; ///< b's channels have the numbers of a's
    ComparedPairs pairs_;
    int mask_ = -1; ///< channel that a manifest calls the alpha mask
    std::size_t mips_ = 0;
    std::vector<MipTable> table_;
    ChannelDifference perChannel_[16], total_;
    double ssim_[16] = {};
    float worst_ = -1.0f;
    std::size_t worstMip_ = 0;
    int worstChannel_ = 0;
};

} // namespace

void AddCompareCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command =
        app.add_subcommand("compare", "Differences of two texture sets, or of a set and its source");
    command->add_option("A", options->first, "Texture set, manifest, folder or image")->required();
    command->add_option("B", options->second, "Texture set, manifest, folder or image")->required();
    command->add_option("--images", options->images, "Folder for side-by-side images: A, B, 8 x difference")
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    AddNumberOption(*command, "--min-psnr", options->minPsnr, {0.0, 1000.0},
                    "Exit 1 when the PSNR is below this", "DB");
    command->add_flag("--discard-masked", options->discardMasked,
                      "Leave out texels whose mask is 0, as `encode --discard-masked` does");
    command->add_flag("--flip", options->flip,
                      "FLIP of textures of three or more channels, as sRGB: how different they look");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return CompareCommand(*options).Run(); }; });
}

} // namespace openntc::tool
