// SPDX-License-Identifier: MIT
#include "report/Filtering.h"

#include "Failure.h"
#include "Interrupt.h"
#include "filtering/WaveEmulator.h" // before what needs waves
#include "textures/BlockMeasurement.h"

#include "openntc/MathModes.h"

#include "openntc/StochasticFiltering.h" // and GLM
#include "openntc/filtering/StfShare.h"

#include <bit>
#include <cmath>
#include <iterator>
#include <map>

namespace openntc::report {

/// A set's mips in memory, and what is read of them.
struct FilteredSet {
    std::vector<std::vector<float>> mips; ///< 16 values a texel
    shader::NtcStfExtent extent{};
};

/// A texel that a lane decodes.
struct DecodedTexel {
    int mip, x, y;
};

struct SetReader {
    const FilteredSet* set;
    std::vector<DecodedTexel>* decoded;
};

inline shader::NtcStfTexel FetchSetTexel(const SetReader& reader, const shader::NtcStfTap& tap) {
    reader.decoded->push_back({tap.mip, tap.texel.x, tap.texel.y});
    const int width = shader::NtcStfGetMipSize(reader.set->extent.width, tap.mip);
    const float* from = &reader.set->mips[static_cast<std::size_t>(tap.mip)]
                                         [16 * static_cast<std::size_t>(tap.texel.y * width + tap.texel.x)];
    shader::NtcStfTexel texel;
    texel.channels0 = {from[0], from[1], from[2], from[3]};
    texel.channels4 = {from[4], from[5], from[6], from[7]};
    texel.channels8 = {from[8], from[9], from[10], from[11]};
    texel.channels12 = {from[12], from[13], from[14], from[15]};
    return texel;
}

} // namespace openntc::report

namespace openntc::shader {

using report::FetchSetTexel;
using report::SetReader;

NTC_STF_DEFINE_FILTER(FilterSetExactly, NtcStfTexel, SetReader, FetchSetTexel)
NTC_STF_DEFINE_COLLABORATION(FilterSetTogether, NtcStfTexel, SetReader, FetchSetTexel)
NTC_STF_DEFINE_SHARING(FilterSetShared, NtcStfTexel, SetReader, FetchSetTexel)

} // namespace openntc::shader

namespace openntc::report {

namespace {

namespace stf = shader;

/// What a pixel sees of the set.
struct PixelView {
    stf::float2 uv, ddx, ddy;
};

constexpr std::uint32_t kWaveLanes = 8; // 4 x 2 pixels

stf::NtcStfSampler MakeFilteringSampler(const std::string& filter) {
    const auto make = [](std::uint32_t kernel) { return stf::NtcStfMakeSampler(kernel, NTC_WRAP_REPEAT); };
    if (filter == "B-spline")
        return make(NTC_KERNEL_CUBIC);
    if (filter == "Catmull-Rom")
        return make(NTC_KERNEL_CATMULL_ROM);
    if (filter == "Mitchell")
        return make(NTC_KERNEL_MITCHELL);
    if (filter == "Gaussian")
        return stf::NtcStfMakeGaussian(0.6f, NTC_WRAP_REPEAT);
    stf::NtcStfSampler settings = make(NTC_KERNEL_BILINEAR); // trilinear
    settings.maxAnisotropy = filter == "anisotropic" ? 8 : 1;
    return settings;
}

/// Sixteen numbers from a texel.
std::array<float, 16> GetChannels(const stf::NtcStfTexel& texel) {
    std::array<float, 16> values;
    const stf::float4* parts[] = {&texel.channels0, &texel.channels4, &texel.channels8, &texel.channels12};
    for (std::size_t i = 0; i < 16; ++i)
        values[i] = (*parts[i / 4])[static_cast<int>(i % 4)];
    return values;
}

} // namespace

class FilteringMeasurement::Scene {
public:
    Scene(const Encoding& encoding, bool quick)
        : encoding_(encoding), data_(encoding.int8), width_(quick ? 16 : 48), height_(quick ? 8 : 32),
          mask_(encoding.GetOutputMask(encoding.record.channels)) {
        tool::BackendOptions one;
        one.threads = 1;
        data_.math = DecodeMath::Int8;
        decoder_ = tool::RequireDecoder(encoding.record.name, data_, one);
        const EncodingRecord& record = encoding.record;
        set_.extent = stf::NtcStfMakeExtent(record.width, record.height, record.mips);
        for (int mip = 0; mip < record.mips; ++mip) {
            const int width = stf::NtcStfGetMipSize(record.width, mip);
            const int height = stf::NtcStfGetMipSize(record.height, mip);
            set_.mips.emplace_back(16 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
            Decode(mip, {0, 0, width, height}, set_.mips.back());
        }
    }

    FilteringRecord Judge(const FilteringCase& c) {
        const Pixels exact = DrawFrame({c.filter, c.isFloor, FilterTexels::All}, 0);
        FilteringRecord record;
        record.id = c.GetId();
        record.filter = c.filter;
        record.scene = c.isFloor ? "floor" : "magnified";
        record.texels = c.GetTexelsName();
        record.encoding = encoding_.record.name;
        record.frames.assign(std::begin(kFilteringFrames), std::end(kFilteringFrames));
        std::size_t decoded = decoded_.size();
        if (c.texels == FilterTexels::All) { // every frame is the same
            record.rmse.assign(record.frames.size(), 0.0);
            record.texelsPerSample = static_cast<double>(decoded) / static_cast<double>(exact.size());
            timed_[record.id] = decoded_;
            return record;
        }
        std::vector<std::array<double, 16>> sums(exact.size());
        decoded = 0;
        int frame = 0;
        for (const int frames : record.frames) {
            for (; frame < frames; ++frame) {
                tool::ThrowIfInterrupted();
                const Pixels pixels = DrawFrame(c, static_cast<std::uint32_t>(frame));
                decoded += decoded_.size();
                if (frame == 0)
                    timed_[record.id] = decoded_;
                for (std::size_t i = 0; i < pixels.size(); ++i) {
                    for (std::size_t k = 0; k < 16; ++k)
                        sums[i][k] += static_cast<double>(pixels[i][k]);
                }
            }
            record.rmse.push_back(GetRmse(sums, frames, exact));
        }
        record.texelsPerSample = static_cast<double>(decoded) / static_cast<double>(exact.size()) / frame;
        return record;
    }

    double Time(const FilteringCase& c) {
        std::array<float, 16> outputs;
        const double start = tool::GetEncodingSeconds(true);
        for (const DecodedTexel& texel : timed_.at(c.GetId()))
            Decode(texel.mip, {texel.x, texel.y, 1, 1}, outputs);
        return 1e9 * (tool::GetEncodingSeconds(true) - start) / (width_ * height_);
    }

private:
    using Pixels = std::vector<std::array<float, 16>>;

    void Decode(int mip, const Rect& rect, std::span<float> outputs) {
        tool::Require(decoder_->Decode(mip, rect, {DecodeMath::Int8, false}, outputs), tool::ExitCode::Failed,
                      encoding_.record.name);
    }

    double GetRmse(const std::vector<std::array<double, 16>>& sums, int frames, const Pixels& exact) const {
        double squares = 0;
        for (std::size_t i = 0; i < sums.size(); ++i) {
            for (std::size_t k = 0; k < 16; ++k) {
                if ((mask_ >> k & 1u) != 0)
                    squares += std::pow(sums[i][k] / frames - static_cast<double>(exact[i][k]), 2);
            }
        }
        return std::sqrt(squares / static_cast<double>(sums.size()) / std::popcount(mask_));
    }

    /// A square turned by 17 degrees, a texel of which is 4 pixels wide; or a floor.
    PixelView See(bool isFloor, int x, int y) const {
        const float px = static_cast<float>(x) + 0.5f, py = static_cast<float>(y) + 0.5f;
        if (isFloor) {
            const float width = static_cast<float>(width_);
            const auto at = [width](float column, float row) {
                const float depth = 6.0f / (row + 2.0f);
                return stf::float2((column - 0.5f * width) / width * depth + 0.37f, depth);
            };
            const stf::float2 uv = at(px, py);
            return {uv, at(px + 1, py) - uv, at(px, py + 1) - uv};
        }
        const float step = 0.25f / static_cast<float>(set_.extent.width);
        const float cosine = 0.9563f * step, sine = 0.2924f * step;
        return {{0.4f + px * cosine - py * sine, 0.3f + px * sine + py * cosine},
                {cosine, sine},
                {-sine, cosine}};
    }

    /// The picture of one frame; decoded_ has what was read for it.
    Pixels DrawFrame(const FilteringCase& c, std::uint32_t frame) {
        const stf::NtcStfSampler settings = MakeFilteringSampler(c.filter);
        Pixels pixels(static_cast<std::size_t>(width_ * height_));
        decoded_.clear();
        for (int y = 0; y < height_; y += 2) {
            for (int x = 0; x < width_; x += 4)
                DrawWave(c, settings, frame, x, y, pixels);
        }
        return pixels;
    }

    /// A lane that is run again counts anew.
    void DrawWave(const FilteringCase& c, const stf::NtcStfSampler& settings, std::uint32_t frame, int left,
                  int top, Pixels& pixels) {
        std::array<std::vector<DecodedTexel>, kWaveLanes> decoded;
        const auto shade = [&](std::uint32_t lane) {
            decoded[lane].clear();
            const int x = left + static_cast<int>((lane & 1u) | ((lane >> 1) & 2u));
            const int y = top + static_cast<int>((lane >> 1) & 1u);
            const PixelView view = See(c.isFloor, x, y);
            const SetReader reader{&set_, &decoded[lane]};
            const stf::NtcStfFootprint footprint =
                stf::NtcStfGetFootprint(settings, set_.extent, view.ddx, view.ddy);
            const stf::uint4 random = stf::NtcStfRandomR2(
                stf::NtcStfPcg4d(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 0, 0), frame);
            pixels[static_cast<std::size_t>(y * width_ + x)] =
                GetChannels(Filter(c.texels, reader, settings, view, footprint, random));
        };
        if (c.texels == FilterTexels::One || c.texels == FilterTexels::All) {
            for (std::uint32_t lane = 0; lane < kWaveLanes; ++lane)
                shade(lane);
        } else {
            wave_.Execute(
                kWaveLanes, [](std::uint32_t) { return true; }, shade);
        }
        for (const std::vector<DecodedTexel>& texels : decoded)
            decoded_.insert(decoded_.end(), texels.begin(), texels.end());
    }

    stf::NtcStfTexel Filter(FilterTexels texels, const SetReader& reader, const stf::NtcStfSampler& settings,
                            const PixelView& view, const stf::NtcStfFootprint& footprint,
                            stf::uint4 random) const {
        const stf::NtcStfExtent& extent = set_.extent;
        if (texels == FilterTexels::All)
            return stf::FilterSetExactly(reader, settings, extent, view.uv, footprint);
        if (texels == FilterTexels::One) {
            const stf::NtcStfPair pair = stf::NtcStfSamplePair(settings, extent, view.uv, footprint, random);
            stf::NtcStfTexel value;
            stf::NtcStfClear(value);
            stf::NtcStfAdd(value, FetchSetTexel(reader, pair.first), pair.first.scale);
            if (pair.second.scale != 0.0f)
                stf::NtcStfAdd(value, FetchSetTexel(reader, pair.second), pair.second.scale);
            return value;
        }
        const stf::NtcStfWaveLane self = stf::NtcStfMakeWaveLane(0, true);
        return texels == FilterTexels::Together
                   ? stf::FilterSetTogether(reader, self, settings, extent, view.uv, footprint, random)
                   : stf::FilterSetShared(reader, self, 4, settings, extent, view.uv, footprint, random);
    }

    const Encoding& encoding_;
    tool::DecodeData data_;
    int width_, height_;
    std::uint32_t mask_;
    std::unique_ptr<tool::Decoder> decoder_;
    FilteredSet set_;
    std::vector<DecodedTexel> decoded_;                      // of the frame that was drawn last
    std::map<std::string, std::vector<DecodedTexel>> timed_; // of a case's first frame
    openntc_filtering::WaveEmulator wave_;
};

std::string FilteringCase::GetId() const {
    return std::string("filtering ") + filter + (isFloor ? ", floor: " : ": ") + GetTexelsName();
}

const char* FilteringCase::GetTexelsName() const {
    switch (texels) {
    case FilterTexels::One:
        return "one texel";
    case FilterTexels::Shared:
        return "2 x 2 share";
    case FilterTexels::Together:
        return "waves collaborate";
    case FilterTexels::All:
        break;
    }
    return "all texels";
}

std::vector<FilteringCase> ListFilteringCases(bool quick) {
    std::vector<FilteringCase> cases;
    const auto add = [&](const char* filter, bool isFloor) {
        for (const FilterTexels texels :
             {FilterTexels::One, FilterTexels::Shared, FilterTexels::Together, FilterTexels::All})
            cases.push_back({filter, isFloor, texels});
    };
    add("trilinear", false);
    if (!quick) {
        add("B-spline", false);
        add("Catmull-Rom", false);
        add("Mitchell", false);
        add("Gaussian", false);
        add("trilinear", true);
    }
    add("anisotropic", true);
    return cases;
}

FilteringMeasurement::FilteringMeasurement(const Encoding& encoding, bool quick)
    : scene_(std::make_unique<Scene>(encoding, quick)) {}
FilteringMeasurement::~FilteringMeasurement() = default;

FilteringRecord FilteringMeasurement::Judge(const FilteringCase& c) {
    return scene_->Judge(c);
}

double FilteringMeasurement::Time(const FilteringCase& c) {
    return scene_->Time(c);
}

std::vector<FilteringRecord> MeasureFiltering(const std::vector<FilteringCase>& cases,
                                              const Encoding& encoding, bool quick,
                                              const std::function<void()>& advance) {
    FilteringMeasurement measurement(encoding, quick);
    std::vector<FilteringRecord> records;
    std::vector<std::vector<double>> times(cases.size());
    for (const FilteringCase& c : cases) {
        records.push_back(measurement.Judge(c));
        advance();
    }
    constexpr int kRounds = 7; // through all cases, so that a change of load meets all of them
    for (int round = 0; round < kRounds; ++round) {
        for (std::size_t i = 0; i < times.size(); ++i)
            times[i].push_back(measurement.Time(cases[i]));
    }
    for (std::size_t i = 0; i < times.size(); ++i)
        records[i].time = Summarise(std::move(times[i]));
    return records;
}

} // namespace openntc::report
