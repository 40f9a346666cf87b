// SPDX-License-Identifier: MIT
// The network's inputs by the independent model. Numbers in brackets are sections of the format specification's network
// document; "latents" names the other one.
#include "ModelSet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace openntc::conformance {

namespace {

// Position of a texel along one axis of a grid [2.1].
struct Axis {
    int first = 0;
    int second = 0;
    double fraction = 0;
    double opposite = 0;
};

// Codes of the four corners, corner by corner, and their binary32 weights.
struct Sample {
    std::array<std::array<int, 16>, 4> codes{};
    std::array<double, 4> weights{};
};

class InputMaker {
public:
    InputMaker(const ModelSet& set, const ModelRequest& request, Mistake mistake)
        : set_(set), request_(request), mistake_(mistake), mip_(set.mips[Index(request.mip)]),
          part_(GetSlicePart(request.slice, request.mip - request.sliceMip, mip_.width, mip_.height)) {}

    std::vector<double> Make() const {
        const ModelImage& image = set_.images[Index(GetImage())];
        const std::size_t slots = Index(set_.highSlots);
        std::vector<double> inputs(4 * slots + 32, 0.0);
        const Sample corners = GetSample(image.high, CountUsed(image.high, set_.highSlots, true));
        for (std::size_t corner = 0; corner < 4; ++corner) {
            for (std::size_t k = 0; k < Index(CountUsed(image.high, set_.highSlots, true)); ++k)
                inputs[corner * slots + k] = FinishLatent(
                    WeightLatent(corners.codes[corner][k], image.high.bits, corners.weights[corner]));
        }
        const Sample blend = GetSample(image.low, CountUsed(image.low, 16, false));
        for (std::size_t k = 0; k < Index(CountUsed(image.low, 16, false)); ++k) {
            double sum = 0;
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const double value =
                    WeightLatent(blend.codes[corner][k], image.low.bits, blend.weights[corner]);
                sum = Makes(Mistake::SeparateLowResShifts) && IsInt8() ? sum + 256 * std::floor(value / 256)
                                                                       : AddLatents(sum, value);
            }
            inputs[4 * slots + k] = FinishLatent(sum);
        }
        AddPositions(&inputs[4 * slots + 16]);
        return inputs;
    }

private:
    bool Makes(Mistake mistake) const { return mistake_ == mistake; }
    bool MakesInSlice(Mistake mistake) const { return Makes(mistake) && request_.kind == RequestKind::Slice; }
    bool IsInt8() const { return request_.math == DecodeMath::Int8 || request_.math == DecodeMath::Int8Half; }

    int GetImage() const {
        const int last = static_cast<int>(set_.images.size()) - 1;
        if (Makes(Mistake::FormulaLatentImage))
            return std::min(std::max(request_.mip - 2, 0) / 2, last);
        return std::clamp(mip_.image, 0, last);
    }

    // The mistakes read on into the latents behind.
    int CountUsed(const ModelGrid& grid, int slots, bool isHigh) const {
        const bool feeds = Makes(Mistake::UnusedSlotsNotZeroed) ||
                           (Makes(Mistake::UnusedSlotsOf8) && isHigh && grid.features == 8 && slots == 16);
        return feeds ? slots : grid.features;
    }

    // The grid's extent along one axis that taps are clamped to.
    std::array<int, 2> GetBounds(bool isVertical, int gridSize) const {
        if (MakesInSlice(Mistake::SliceLatentsOfCoarsest))
            return GetLatentsOfSlice(isVertical, gridSize, GetImage(), true);
        if (MakesInSlice(Mistake::SliceLatentsOfFinest))
            return GetLatentsOfSlice(isVertical, gridSize, GetImage(), false);
        if (!MakesInSlice(Mistake::SlicesWithoutBorder))
            return {0, gridSize - 1};
        const double scale = static_cast<double>(gridSize) / (isVertical ? mip_.height : mip_.width);
        const int left = isVertical ? part_.top : part_.left;
        const int length = isVertical ? part_.height : part_.width;
        const int first = std::clamp(static_cast<int>(std::floor(left * scale)), 0, gridSize - 1);
        const int last = static_cast<int>(std::ceil((left + length) * scale)) - 1;
        return {first, std::clamp(last, first, gridSize - 1)};
    }

    // The latents of a slice along one axis [streaming 3.2]: those that the rectangle needs as it lies in the coarsest
    // mip that the image serves there, or in the finest.
    std::array<int, 2> GetLatentsOfSlice(bool isVertical, int gridSize, int image, bool isCoarsest) const {
        int chosen = request_.mip;
        for (int mip = request_.sliceMip; mip < request_.sliceMip + request_.sliceMips; ++mip) {
            if (set_.mips[Index(mip)].image == image && (isCoarsest ? mip > chosen : mip < chosen))
                chosen = mip;
        }
        const int level = chosen - request_.sliceMip;
        const int begin = isVertical ? request_.slice.top : request_.slice.left;
        const int end = begin + (isVertical ? request_.slice.height : request_.slice.width);
        const double size = isVertical ? set_.mips[Index(chosen)].height : set_.mips[Index(chosen)].width;
        const auto scale = [&](int edge) {
            const double place = RoundToBinary32(RoundToBinary32(edge / size) * gridSize);
            return static_cast<int>(std::trunc(RoundToBinary32(place - 0.5)));
        };
        return {std::max(scale(begin >> level), 0),
                std::min(scale(((end - 1) >> level) + 1) + 1, gridSize - 1)};
    }

    Axis GetAxis(int texel, int mipSize, int gridSize, std::array<int, 2> bounds) const {
        double where = texel;
        if (Makes(Mistake::UnsignedTexels) && texel < 0)
            where += 0x1p32;
        const double u = RoundToBinary32((where + 0.5) / mipSize);
        double position = RoundToBinary32(RoundToBinary32(u * gridSize) - 0.5);
        if (Makes(Mistake::Contraction))
            position = RoundToBinary32(u * gridSize - 0.5);
        if (Makes(Mistake::ReorderedCoordinates))
            position = RoundToBinary32(
                RoundToBinary32((where + 0.5) * RoundToBinary32(static_cast<double>(gridSize) / mipSize)) -
                0.5);
        const double cell = Makes(Mistake::TruncatedCells) ? std::trunc(position) : std::floor(position);
        const auto get = [&](double tap) {
            if (Makes(Mistake::WrappedTaps))
                return static_cast<int>(tap - std::floor(tap / gridSize) * gridSize);
            return static_cast<int>(
                std::clamp(tap, static_cast<double>(bounds[0]), static_cast<double>(bounds[1])));
        };
        double fraction = RoundToBinary32(position - cell);
        if (Makes(Mistake::NearestLatents))
            fraction = fraction < 0.5 ? 0 : 1;
        Axis axis{get(cell), get(cell + 1), fraction, RoundToBinary32(1 - fraction)};
        if (Makes(Mistake::ReversedTaps))
            std::swap(axis.fraction, axis.opposite);
        return axis;
    }

    int LoadCode(const ModelGrid& grid, std::size_t bit) const {
        if (bit / 8 >= grid.size || grid.offset + bit / 8 >= set_.file.size())
            return 0;
        const int byte = std::to_integer<int>(set_.file[grid.offset + bit / 8]);
        const int mask = (1 << grid.bits) - 1;
        const int shift = static_cast<int>(bit % 8);
        if (Makes(Mistake::WrongBitOrder))
            return byte >> (8 - grid.bits - shift) & mask;
        const int code = byte >> shift & mask;
        return Makes(Mistake::Code255As254) && code == 255 ? 254 : code;
    }

    std::size_t GetRowBit(const ModelGrid& grid, std::size_t row) const {
        const std::size_t bit = row * grid.rowBits;
        return MakesInSlice(Mistake::SliceRowsAtBytes) ? bit / 8 * 8 : bit;
    }

    // Bit of element 0 of a pixel.
    std::size_t GetPixelBit(const ModelGrid& grid, int x, int y) const {
        return GetRowBit(grid, Index(y)) + Index(x) * Index(grid.stride) * Index(grid.bits);
    }

    // The code that lies at the pixel's place in the slice's block of another image.
    int LoadCodeOf(const ModelImage& other, int otherImage, const ModelGrid& grid, int x, int y,
                   int k) const {
        const ModelImage& own = set_.images[Index(GetImage())];
        const ModelGrid& block = &grid == &own.high ? other.high : other.low;
        const auto columns = GetLatentsOfSlice(false, grid.width, GetImage(), true);
        const auto rows = GetLatentsOfSlice(true, grid.height, GetImage(), true);
        const int place = (y - rows[0]) * (columns[1] - columns[0] + 1) + x - columns[0];
        const auto blockColumns = GetLatentsOfSlice(false, block.width, otherImage, true);
        const auto blockRows = GetLatentsOfSlice(true, block.height, otherImage, true);
        const int width = blockColumns[1] - blockColumns[0] + 1;
        if (place < 0 || place / width > blockRows[1] - blockRows[0])
            return 0;
        return LoadCode(block,
                        GetPixelBit(block, blockColumns[0] + place % width, blockRows[0] + place / width) +
                            Index(k) * Index(block.bits));
    }

    // The first latent image that the slice has.
    int GetFirstImageOfSlice() const {
        int first = GetImage();
        for (int mip = request_.sliceMip; mip < request_.sliceMip + request_.sliceMips; ++mip)
            first = std::min(first, set_.mips[Index(mip)].image);
        return first;
    }

    Sample GetSample(const ModelGrid& grid, int used) const {
        const Axis h = GetAxis(request_.x, mip_.width, grid.width, GetBounds(false, grid.width));
        const Axis v = GetAxis(request_.y, mip_.height, grid.height, GetBounds(true, grid.height));
        const int first = MakesInSlice(Mistake::SliceImagesAtStart) ? GetFirstImageOfSlice() : GetImage();
        Sample sample;
        sample.weights = {RoundToBinary32(h.opposite * v.opposite), RoundToBinary32(h.fraction * v.opposite),
                          RoundToBinary32(h.opposite * v.fraction), RoundToBinary32(h.fraction * v.fraction)};
        for (int corner = 0; corner < 4; ++corner) {
            const int px = (corner & 1) != 0 ? h.second : h.first;
            const int py = (corner & 2) != 0 ? v.second : v.first;
            for (int k = 0; k < used; ++k)
                sample.codes[Index(corner)][Index(k)] =
                    first == GetImage()
                        ? LoadCode(grid, GetPixelBit(grid, px, py) + Index(k) * Index(grid.bits))
                        : LoadCodeOf(set_.images[Index(first)], first, grid, px, py, k);
        }
        if (Makes(Mistake::SwappedCorners))
            std::swap(sample.codes[1], sample.codes[2]);
        return sample;
    }

    // Level of a code in units of 1/127.5 [latents 6.2].
    int GetLevel(int code, int bits) const {
        switch (bits) {
        case 1:
            return Makes(Mistake::SymmetricOneBit) ? code * 170 - 85 : code * 85;
        case 2:
            return Makes(Mistake::SymmetricTwoBits) ? code * 68 - 102 : code * 51 - 51;
        case 4:
            return Makes(Mistake::SymmetricFourBits) ? code * 16 - 120 : code * 15 - 105;
        default:
            return Makes(Mistake::UnsignedLatents) ? code - 128 : code - 126;
        }
    }

    static double GetHalfLatent(int code, int bits) { // [latents 6.3]
        const double levels = bits == 8 ? 127.5 : std::ldexp(1.0, bits - 1) + 0.5;
        const double step = RoundToBinary32(1 / levels);
        const double bias = RoundToBinary32((1.5 - levels) * step);
        return RoundToHalf(RoundToHalf(code * RoundToHalf(step)) + RoundToHalf(bias));
    }

    // [3.1], [5] and the definitions of the maths modes.
    double WeightLatent(int code, int bits, double weight) const {
        switch (request_.math) {
        case DecodeMath::FP8:
            return RoundToHalf(GetHalfLatent(code, bits) * RoundToHalf(weight));
        case DecodeMath::FP16:
            return RoundToHalf(GetLevel(code, bits) / 128.0 * RoundToHalf(weight));
        case DecodeMath::FP32:
            return RoundToBinary32(GetLevel(code, bits) * weight);
        default:
            break;
        }
        const double parts = 256 * weight;
        int level = GetLevel(code, bits);
        if (Makes(Mistake::SaturatedLatents))
            level = std::min(level, 127);
        const double whole = Makes(Mistake::RoundedWeights)       ? std::nearbyint(parts)
                             : Makes(Mistake::TruncatedFractions) ? 2 * std::trunc(parts / 2)
                                                                  : std::trunc(parts);
        return level * whole;
    }

    double FinishLatent(double value) const {
        if (request_.math == DecodeMath::FP8)
            return RoundToE4M3With(mistake_, value);
        if (!IsInt8())
            return value;
        const double shifted = value / 256;
        return ToSignedByte(static_cast<std::int64_t>(Makes(Mistake::TruncatedShift) ? std::trunc(shifted)
                                                                                     : std::floor(shifted)));
    }

    double AddLatents(double sum, double value) const {
        const DecodeMath math = request_.math;
        return math == DecodeMath::FP32                              ? RoundToBinary32(sum + value)
               : math == DecodeMath::FP16 || math == DecodeMath::FP8 ? RoundToHalf(sum + value)
                                                                     : sum + value;
    }

    // Waves [2.2] and level of detail: 14 inputs.
    void AddPositions(double* out) const {
        const double half = Makes(Mistake::HalfTexelWaves) ? 0.5 : 0;
        const double scale = Makes(Mistake::PositionScaleIgnored) ? 1 : static_cast<double>(mip_.scale);
        const auto get = [&](int texel, int origin) {
            double where = texel;
            if (MakesInSlice(Mistake::RebasedSlices))
                where -= origin;
            if (Makes(Mistake::UnsignedTexels) && texel < 0)
                where += 0x1p32;
            return RoundToBinary32(RoundToBinary32(where + half) * scale);
        };
        double qx = get(request_.x, part_.left);
        double qy = get(request_.y, part_.top);
        if (Makes(Mistake::SwappedWaves))
            std::swap(qx, qy);
        const double quarter = Makes(Mistake::WavePhase) ? 0.75 : 0.25;
        for (int wave = 0; wave < 3; ++wave) {
            const double frequency =
                std::ldexp(1.0, Makes(Mistake::ReversedFrequencies) ? -1 - wave : wave - 3);
            double* const four = out + 4 * wave;
            four[0] = FinishWave(GetWave(qx, frequency, 0), false);
            four[1] = FinishWave(GetWave(qy, frequency, 0), false);
            four[2] = FinishWave(GetWave(qx, frequency, quarter), false);
            four[3] = FinishWave(GetWave(qy, frequency, quarter), false);
            if (Makes(Mistake::WaveOrder))
                std::swap(four[1], four[2]);
        }
        out[12] = FinishWave(static_cast<double>(mip_.lod), true);
        out[13] = Makes(Mistake::LodOnce) ? 0 : out[12];
    }

    double GetWave(double position, double frequency, double phase) const {
        const double t = RoundToBinary32(position * frequency + phase);
        const double whole = Makes(Mistake::TruncatedWaves) ? std::trunc(t) : std::floor(t);
        const double centred = RoundToBinary32(4 * RoundToBinary32(t - whole) - 2);
        return RoundToBinary32(std::fabs(centred) - 1);
    }

    double FinishWave(double e, bool isLod) const {
        if (request_.math == DecodeMath::FP8)
            return RoundToE4M3With(mistake_,
                                   RoundToHalf(Makes(Mistake::FP8LodClamped) ? std::clamp(e, -1.0, 1.0) : e));
        if (!IsInt8()) {
            if (isLod && !Makes(Mistake::MissingLodClamp))
                e = std::clamp(e, -1.0, 1.0);
            return request_.math == DecodeMath::FP32 ? RoundToBinary32(e * 127.5)
                                                     : RoundToHalf(RoundToBinary32(e * (127.5 / 128)));
        }
        double scaled = RoundToBinary32(e * 127.5);
        if (!Makes(Mistake::MissingLodClamp))
            scaled = std::clamp(scaled, -128.0, 127.0);
        return ToSignedByte(static_cast<std::int64_t>(Makes(Mistake::RoundedWaves) ? std::nearbyint(scaled)
                                                                                   : std::trunc(scaled)));
    }

    const ModelSet& set_;
    const ModelRequest& request_;
    Mistake mistake_;
    const ModelMip& mip_;
    const Rect part_; // of slices: what it holds of this mip
};

} // namespace

double RoundToE4M3With(Mistake mistake, double x) {
    if (mistake == Mistake::FP8SubnormalsFlushed && std::fabs(x) < 0x1p-6)
        return 0;
    if (mistake == Mistake::FP8SaturationMissing && std::fabs(x) >= 464)
        return std::numeric_limits<double>::quiet_NaN();
    if (mistake == Mistake::E4M3Max480 && std::fabs(x) >= 464)
        return std::copysign(480, x);
    return mistake == Mistake::TruncatedE4M3  ? CutToE4M3(x)
           : mistake == Mistake::E4M3TiesAway ? RoundAwayToE4M3(x)
                                              : RoundToE4M3(x);
}

std::vector<double> GetModelInputs(const ModelSet& set, const ModelRequest& request, Mistake mistake) {
    if (set.generation > 1)
        return GetLatentMipInputs(set, request, mistake);
    return InputMaker(set, request, mistake).Make();
}

} // namespace openntc::conformance
