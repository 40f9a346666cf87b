// SPDX-License-Identifier: MIT
// The inputs of generations 2 and 3 by the independent model. Numbers in brackets are sections of the format
// specification's document of generations. Sampling is OpenNTC's, of which docs/shaders.md has the definition.
#include "ModelSet.h"

#include <algorithm>
#include <cmath>

namespace openntc::conformance {

namespace {

class MipInputMaker {
public:
    MipInputMaker(const ModelSet& set, const ModelRequest& request, Mistake mistake)
        : set_(set), request_(request), mistake_(mistake), mip_(set.mips[Index(request.mip)]) {}

    std::vector<double> Make() const { // [5]
        std::vector<double> inputs(48, 0.0);
        const int second = mip_.image + (Makes(Mistake::OneLatentMip) ? 0 : 1);
        Sample(set_.latentMips[Index(mip_.image)], inputs.data());
        Sample(set_.latentMips[Index(second)], inputs.data() + 16);
        const double column = RoundToBinary32(request_.x * static_cast<double>(mip_.scale));
        const double row = RoundToBinary32(request_.y * static_cast<double>(mip_.scale));
        for (int wave = 0; wave < 3; ++wave) {
            const double frequency =
                std::ldexp(1.0, wave - (Makes(Mistake::FrequenciesOfGeneration1) ? 3 : 0));
            double* const four = &inputs[32 + 4 * Index(wave)];
            four[0] = FinishWave(GetWave(column * frequency));
            four[1] = FinishWave(GetWave(row * frequency));
            four[2] = FinishWave(GetWave(RoundToBinary32(column * frequency + 0.25)));
            four[3] = FinishWave(GetWave(RoundToBinary32(row * frequency + 0.25)));
        }
        const double lod = static_cast<double>(mip_.lod);
        const bool isReal = request_.math == DecodeMath::FP16 || request_.math == DecodeMath::FP32;
        inputs[44] = inputs[45] = FinishWave(isReal ? std::clamp(lod, -1.0, 1.0) : lod);
        return inputs;
    }

private:
    // Between two texels of an axis, a part of the way from one to the other.
    struct Place {
        int first, second;
        double fraction;
    };

    bool Makes(Mistake mistake) const { return mistake_ == mistake; }
    bool IsInt8() const { return request_.math == DecodeMath::Int8 || request_.math == DecodeMath::Int8Half; }

    Place Locate(int texel, int mipSize, int size) const {
        const int wrapped = (texel % mipSize + mipSize) % mipSize;
        const double centre = RoundToBinary32((wrapped + 0.5) / mipSize);
        const double position = RoundToBinary32(RoundToBinary32(centre * size) - 0.5);
        const int cell = static_cast<int>(std::floor(position));
        const double fraction = RoundToBinary32(position - cell);
        if (Makes(Mistake::ClampedBorders))
            return {std::max(cell, 0), std::min(cell + 1, size - 1), fraction};
        return {(cell + size) % size, (cell + 1) % size, fraction};
    }

    int LoadCode(const ModelLatentMip& mip, int feature, int x, int y) const {
        const int layers = static_cast<int>(mip.layers.size());
        const int layer = Makes(Mistake::ReversedLayers) ? layers - 1 - feature / 4 : feature / 4;
        const int place = Makes(Mistake::ReversedTexelCodes) ? 3 - feature % 4 : feature % 4;
        const std::size_t at = mip.layers[Index(layer)] + 2 * (Index(y) * Index(mip.width) + Index(x));
        const int byte = std::to_integer<int>(set_.file[at + Index(place / 2)]);
        return byte >> (4 * (place % 2)) & 15;
    }

    void Sample(const ModelLatentMip& mip, double* out) const {
        const Place h = Locate(request_.x, mip_.width, mip.width);
        const Place v = Locate(request_.y, mip_.height, mip.height);
        // Int8: weights of 8 bits a side, so that sums are integers; else binary32.
        const double right = IsInt8() ? std::floor(256 * h.fraction + 0.5) / 256 : h.fraction;
        const double bottom = IsInt8() ? std::floor(256 * v.fraction + 0.5) / 256 : v.fraction;
        const double left = RoundToBinary32(1 - right);
        const double top = RoundToBinary32(1 - bottom);
        const double weights[4] = {RoundToBinary32(left * top), RoundToBinary32(right * top),
                                   RoundToBinary32(left * bottom), RoundToBinary32(right * bottom)};
        for (int feature = 0; feature < 4 * static_cast<int>(mip.layers.size()); ++feature) {
            double sum = 0;
            for (int corner = 0; corner < 4; ++corner) {
                const int code = LoadCode(mip, feature, corner % 2 == 0 ? h.first : h.second,
                                          corner / 2 == 0 ? v.first : v.second);
                sum = RoundToBinary32(sum + RoundToBinary32(code * weights[corner]));
            }
            out[feature] = FinishLatent(sum);
        }
        for (int feature = 4 * static_cast<int>(mip.layers.size()); feature < 16; ++feature)
            out[feature] = Makes(Mistake::AbsentLayersAsCodes) ? FinishLatent(0) : 0;
    }

    // From the weighted sum of codes.
    double FinishLatent(double sum) const {
        const bool isSecond = set_.generation == 2;
        if (request_.math == DecodeMath::FP8)
            return RoundToE4M3With(
                mistake_, RoundToHalf(RoundToBinary32(RoundToBinary32(sum * RoundToBinary32(2.0 / 15)) - 1)));
        const double level = 17 * (Makes(Mistake::SixteenSteps) ? sum * 15 / 16 : sum); // 255 q
        if (IsInt8()) {
            const bool truncates = isSecond != Makes(Mistake::LatentsOfOtherGeneration);
            return ToSignedByte(
                static_cast<std::int64_t>(truncates ? std::trunc(level - 127.5) : std::floor(level - 128)));
        }
        const double x = RoundToBinary32(RoundToBinary32(level) - (isSecond ? 127.5 : 128));
        return request_.math == DecodeMath::FP16 ? RoundToHalf(x / 128) : x;
    }

    double GetWave(double t) const {
        const double fraction = RoundToBinary32(t - std::floor(t));
        if (Makes(Mistake::TriangleWaves))
            return std::fabs(4 * fraction - 2) - 1;
        return RoundToBinary32(2 * fraction - 1);
    }

    double FinishWave(double e) const {
        switch (request_.math) {
        case DecodeMath::FP8:
            return RoundToE4M3With(mistake_, RoundToHalf(e));
        case DecodeMath::FP16:
            return RoundToHalf(RoundToBinary32(e * (127.5 / 128)));
        case DecodeMath::FP32:
            return RoundToBinary32(e * 127.5);
        default:
            break;
        }
        const double scaled = RoundToBinary32(e * 127.5);
        return ToSignedByte(static_cast<std::int64_t>(Makes(Mistake::FlooredWaves) ? std::floor(scaled - 0.5)
                                                                                   : std::trunc(scaled)));
    }

    const ModelSet& set_;
    const ModelRequest& request_;
    Mistake mistake_;
    const ModelMip& mip_;
};

} // namespace

std::vector<double> GetLatentMipInputs(const ModelSet& set, const ModelRequest& request, Mistake mistake) {
    return MipInputMaker(set, request, mistake).Make();
}

} // namespace openntc::conformance
