// SPDX-License-Identifier: MIT
// Mistakes of a decoder that are no arithmetic: wrong contents of the set, another texel, changed outputs.
#include "ModelSet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace openntc::conformance {

namespace {

template <typename Function>
void ForEachGrid(ModelSet& set, Function function) {
    for (ModelImage& image : set.images) {
        function(image.high);
        function(image.low);
    }
}

// Pixels of rows that start at a multiple of `bits`.
void PadRows(ModelGrid& grid, std::size_t bits) {
    grid.rowBits = (Index(grid.width) * Index(grid.stride) * Index(grid.bits) + bits - 1) / bits * bits;
}

// As a decoder addresses the grid that takes its pixels to have that many elements of so many bits.
void SetElements(ModelGrid& grid, int stride, int bits) {
    grid.stride = stride;
    grid.bits = bits;
    PadRows(grid, 1);
}

void ZeroGrids(ModelSet& set, int features, int bits) {
    ForEachGrid(set, [&](ModelGrid& grid) {
        if (grid.features == features && grid.bits == bits)
            grid.size = 0;
    });
}

// Every mip takes the next latent image.
void ShiftImages(ModelSet& set, int scale) {
    const ModelGrid& finest = set.images.front().high;
    if ((set.width + finest.width / 2) / finest.width != scale)
        return;
    for (ModelMip& mip : set.mips)
        mip.image = std::min(mip.image + 1, static_cast<int>(set.images.size()) - 1);
}

void UseFormulaPositions(ModelSet& set) {
    for (std::size_t m = 0; m < set.mips.size(); ++m) {
        const int distance = static_cast<int>(m) - 2 * set.mips[m].image;
        set.mips[m].lod = static_cast<float>(distance / 3.0);
        set.mips[m].scale = static_cast<float>(std::ldexp(1.0, distance));
    }
}

void UseFormulaGrids(ModelSet& set) {
    const ModelGrid finest = set.images.front().high;
    for (std::size_t n = 0; n < set.images.size(); ++n) {
        const auto fit = [&](ModelGrid& grid, std::size_t shift) {
            grid.width = std::max(finest.width >> shift, 1);
            grid.height = std::max(finest.height >> shift, 1);
            PadRows(grid, 1);
        };
        fit(set.images[n].high, 2 * n);
        fit(set.images[n].low, 2 * n + 1);
    }
}

// The texel that has the request's place in an answer that begins with the coarsest mip.
void ReverseSliceMips(const ModelSet& set, ModelRequest& request) {
    const auto getPart = [&](int mip) {
        const ModelMip& size = set.mips[Index(mip)];
        return GetSlicePart(request.slice, mip - request.sliceMip, size.width, size.height);
    };
    const Rect own = getPart(request.mip);
    int place = (request.y - own.top) * own.width + request.x - own.left;
    for (int mip = request.sliceMip; mip < request.mip; ++mip)
        place += getPart(mip).width * getPart(mip).height;
    for (int mip = request.sliceMip + request.sliceMips - 1; mip >= request.sliceMip; --mip) {
        const Rect part = getPart(mip);
        if (place < part.width * part.height) {
            request.mip = mip;
            request.x = part.left + place % part.width;
            request.y = part.top + place / part.width;
            return;
        }
        place -= part.width * part.height;
    }
}

} // namespace

void EditSet(Mistake mistake, ModelSet& set) {
    switch (mistake) {
    case Mistake::TwoLatentImages:
        for (ModelMip& mip : set.mips)
            mip.image = std::min(mip.image, 1);
        break;
    case Mistake::ImageOffByOneAtScale3:
        return ShiftImages(set, 3);
    case Mistake::ImageOffByOneAtScale5:
        return ShiftImages(set, 5);
    case Mistake::ImageOffByOneAtScale6:
        return ShiftImages(set, 6);
    case Mistake::ImageOffByOneAtScale7:
        return ShiftImages(set, 7);
    case Mistake::ImageOffByOneAtScale8:
        return ShiftImages(set, 8);
    case Mistake::LowResOfImage0:
        for (ModelImage& image : set.images)
            image.low = set.images.front().low;
        break;
    case Mistake::ImageOfEarlierMip:
        for (std::size_t m = 1; m < set.mips.size(); ++m)
            set.mips[m].image = std::max(set.mips[m].image, set.mips[m - 1].image);
        break;
    case Mistake::FormulaGrids:
        return UseFormulaGrids(set);
    case Mistake::FormulaPositions:
        return UseFormulaPositions(set);
    case Mistake::RoundedUpMips:
        for (std::size_t m = 0; m < set.mips.size(); ++m) {
            const int round = (1 << m) - 1;
            set.mips[m].width = (set.width + round) >> m;
            set.mips[m].height = (set.height + round) >> m;
        }
        break;
    case Mistake::PixelsOfPowerOfTwo:
        return ForEachGrid(set, [](ModelGrid& grid) {
            SetElements(grid, grid.features == 12 ? 16 : grid.features, grid.bits);
        });
    case Mistake::TwelveByOneAsSixteen:
        return ForEachGrid(set, [](ModelGrid& grid) {
            SetElements(grid, grid.features == 12 && grid.bits == 1 ? 16 : grid.features, grid.bits);
        });
    case Mistake::TwelveByTwoZero:
        return ZeroGrids(set, 12, 2);
    case Mistake::SixteenByEightZero:
        return ZeroGrids(set, 16, 8);
    case Mistake::SwappedBitWidths:
        for (ModelImage& image : set.images) {
            const int bits = image.high.bits;
            SetElements(image.high, image.high.features, image.low.bits);
            SetElements(image.low, image.low.features, bits);
        }
        break;
    case Mistake::RowsPaddedToBytes:
        return ForEachGrid(set, [](ModelGrid& grid) { PadRows(grid, 8); });
    case Mistake::RowsPaddedToWords:
        return ForEachGrid(set, [](ModelGrid& grid) { PadRows(grid, 32); });
    case Mistake::SharedColorSpace:
        set.colorSpaces.fill(set.colorSpaces.front());
        break;
    case Mistake::ColorSpaceOfTexture:
        for (std::size_t c = 0; c < 16; ++c)
            set.colorSpaces[c] = set.colorSpaces[c - c % 4];
        break;
    case Mistake::Channel15Stored:
        set.colorSpaces[15] = 0;
        break;
    default:
        break;
    }
}

std::optional<ModelRequest> EditRequest(Mistake mistake, const ModelSet& set, ModelRequest request) {
    const ModelMip& mip = set.mips[Index(request.mip)];
    const bool isWhole = request.kind == RequestKind::WholeMip;
    const int number = request.y * mip.width + request.x; // of whole mips
    switch (mistake) {
    case Mistake::NextMip:
        if (request.mip + 1 < static_cast<int>(set.mips.size())) {
            ++request.mip;
            request.x = std::min(request.x / 2, set.mips[Index(request.mip)].width - 1);
            request.y = std::min(request.y / 2, set.mips[Index(request.mip)].height - 1);
        }
        break;
    case Mistake::FlippedRows:
        request.y = mip.height - 1 - request.y;
        break;
    case Mistake::TransposedTexels:
        std::swap(request.x, request.y);
        break;
    case Mistake::ClampedTexels:
        request.x = std::clamp(request.x, 0, mip.width - 1);
        request.y = std::clamp(request.y, 0, mip.height - 1);
        break;
    case Mistake::WholeMipPaddedRows:
        if (isWhole) {
            const int stride = (mip.width + 7) / 8 * 8;
            request.x = number % stride;
            request.y = number / stride;
            if (request.x >= mip.width)
                return std::nullopt;
        }
        break;
    case Mistake::WholeMipByColumns:
        if (isWhole) {
            request.x = number / mip.height;
            request.y = number % mip.height;
        }
        break;
    case Mistake::WholeMipFromMip1:
        if (isWhole && request.mip != 1 && set.mips.size() > 1) {
            request.mip = 1;
            request.x = std::min(request.x, set.mips[1].width - 1);
            request.y = std::min(request.y, set.mips[1].height - 1);
        }
        break;
    case Mistake::WholeMipPartialBlocks:
        if (isWhole && (request.x >= mip.width / 8 * 8 || request.y >= mip.height / 8 * 8))
            return std::nullopt;
        break;
    case Mistake::SliceMipsUnshifted:
        if (request.kind == RequestKind::Slice) {
            const int level = request.mip - request.sliceMip;
            request.x =
                std::min(request.x + request.slice.left - (request.slice.left >> level), mip.width - 1);
            request.y =
                std::min(request.y + request.slice.top - (request.slice.top >> level), mip.height - 1);
        }
        break;
    case Mistake::SliceMipsReversed:
        if (request.kind == RequestKind::Slice)
            ReverseSliceMips(set, request);
        break;
    default:
        break;
    }
    return request;
}

void EditOutputs(Mistake mistake, const ModelSet& set, DecodeMath math, std::array<double, 16>& outputs) {
    const double greatest =
        math == DecodeMath::Int8Half ? 65504 : static_cast<double>(std::numeric_limits<float>::max());
    switch (mistake) {
    case Mistake::SwappedChannels:
        std::swap(outputs[0], outputs[1]);
        break;
    case Mistake::ReversedColors:
        std::swap(outputs[0], outputs[2]);
        break;
    case Mistake::RotatedChannels:
        std::rotate(outputs.begin(), outputs.begin() + 1, outputs.end());
        break;
    case Mistake::UndeclaredZero:
        std::fill(outputs.begin() + set.channels, outputs.end(), 0.0);
        break;
    case Mistake::ClampedOutputs:
        for (double& output : outputs)
            output = std::clamp(output, 0.0, 1.0);
        break;
    case Mistake::InfinityAsNan:
    case Mistake::InfinityAsMaximum:
        for (double& output : outputs) {
            if (std::isinf(output))
                output = mistake == Mistake::InfinityAsNan ? std::numeric_limits<double>::quiet_NaN()
                                                           : std::copysign(greatest, output);
        }
        break;
    default:
        break;
    }
}

double ConvertWithMistake(Mistake mistake, const ModelSet& set, std::size_t channel, double stored) {
    const ColorSpace space = static_cast<ColorSpace>(set.colorSpaces[channel]);
    if (space == ColorSpace::sRGB) {
        switch (mistake) {
        case Mistake::SrgbTwice:
            return ConvertToLinear(ConvertToLinear(stored, space), space);
        case Mistake::Gamma22:
            return stored <= 0 ? 0 : std::pow(stored, 2.2);
        case Mistake::SrgbNegativeZero:
            return stored <= 0 ? 0 : ConvertToLinear(stored, space);
        case Mistake::SrgbKnee:
            return stored > 0.02 && stored <= 0.04045 ? std::pow((stored + 0.055) / 1.055, 2.4)
                                                      : ConvertToLinear(stored, space);
        default:
            break;
        }
    }
    if (space == ColorSpace::HLG) {
        const double h = std::fabs(stored);
        const auto curve = [&](double a, double b) {
            const double e = h < 0.5 ? 4 * h * h : std::exp((h - 0.55991073) / a) + b;
            return stored < 0 ? -e : e;
        };
        switch (mistake) {
        case Mistake::HlgWithoutSign:
            return ConvertToLinear(h, space);
        case Mistake::HlgConstantA:
            return curve(0.178832, 0.28466892);
        case Mistake::HlgConstantB:
            return curve(0.17883277, 0.2847);
        case Mistake::HlgClamped:
            return std::clamp(ConvertToLinear(stored, space), 0.0, 12.0);
        default:
            break;
        }
    }
    return ConvertToLinear(stored, space);
}

} // namespace openntc::conformance
