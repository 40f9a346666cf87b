// SPDX-License-Identifier: MIT
// What a texture unit may return for a latent: Vulkan says how precisely it knows its place between texels
// (subTexelPrecisionBits); of the arithmetic behind it only that it keeps 8 bits is taken for granted.
#pragma once

#include "unit/decode/LatentMipSets.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace openntc_tests {

/// Of a latent q, 0 … 1.
struct LatentInterval {
    double low = 1, high = 0;
};

/// Mistakes of a sampler, to see that the interval is narrow enough to tell.
enum class LatentMistake { None, Clamp, SwappedLayers, OneLatentMip, TexelCorners, ReversedBits, HalfAMip };

struct LatentSample {
    int latentMip, feature;
    double u, v;
};

class LatentSampler {
public:
    LatentSampler(const decode_test::LatentMipSet& set, unsigned subTexelPrecisionBits,
                  LatentMistake mistake = LatentMistake::None)
        : set_(set), step_(std::ldexp(1.0, -static_cast<int>(subTexelPrecisionBits))), mistake_(mistake) {}

    LatentInterval GetInterval(LatentSample s) const {
        if (mistake_ == LatentMistake::SwappedLayers)
            s.feature = (s.feature + 4) % set_.GetShape().features;
        if (mistake_ == LatentMistake::ReversedBits)
            s.feature ^= 3;
        if (mistake_ == LatentMistake::OneLatentMip)
            s.latentMip &= ~1;
        if (mistake_ == LatentMistake::HalfAMip)
            s.u += 0.5;
        const unsigned size = set_.GetGridSize(s.latentMip);
        const int width = static_cast<int>(size & 0xFFFFu), height = static_cast<int>(size >> 16);
        // The blend is linear in each coordinate between texel centres: its extremes lie at the ends or at centres.
        LatentInterval interval;
        bool isFlat = true;
        const unsigned corner = GetCode(s, 0, 0, width, height, s.u * width, s.v * height);
        for (const double x : ListPlaces(s.u, width)) {
            for (const double y : ListPlaces(s.v, height)) {
                const double value = Blend(s, x, y, width, height, corner, isFlat) / 15;
                interval.low = std::min(interval.low, value);
                interval.high = std::max(interval.high, value);
            }
        }
        if (isFlat) // a blend of equal numbers
            return interval;
        constexpr double kError = 2.0 / 255; // two interpolations, each off by less than one in 8 bits
        return {std::max(interval.low - kError, 0.0), std::min(interval.high + kError, 1.0)};
    }

private:
    /// Where the device may take u to be, in texels from the centre of texel 0, and centres between.
    std::vector<double> ListPlaces(double u, int size) const {
        const double half = mistake_ == LatentMistake::TexelCorners ? 0.0 : 0.5;
        const double place = u * size - half;
        const double error = step_ + std::ldexp(size, -23); // its grid; u, a product and a sum in binary32
        std::vector<double> places = {place - error, place + error};
        for (double center = std::ceil(places[0]); center < places[1]; ++center)
            places.push_back(center);
        return places;
    }
    int Wrap(int i, int size) const {
        return mistake_ == LatentMistake::Clamp ? std::clamp(i, 0, size - 1) : (i % size + size) % size;
    }
    unsigned GetCode(const LatentSample& s, int dx, int dy, int width, int height, double x, double y) const {
        return set_.GetCode(s.latentMip, s.feature, Wrap(static_cast<int>(std::floor(x)) + dx, width),
                            Wrap(static_cast<int>(std::floor(y)) + dy, height));
    }
    double Blend(const LatentSample& s, double x, double y, int width, int height, unsigned corner,
                 bool& isFlat) const {
        const double fx = x - std::floor(x), fy = y - std::floor(y);
        double sum = 0;
        for (int dy = 0; dy < 2; ++dy) {
            for (int dx = 0; dx < 2; ++dx) {
                const unsigned code = GetCode(s, dx, dy, width, height, x, y);
                isFlat = isFlat && code == corner;
                sum += code * (dx == 0 ? 1 - fx : fx) * (dy == 0 ? 1 - fy : fy);
            }
        }
        return sum;
    }

    const decode_test::LatentMipSet& set_;
    double step_;
    LatentMistake mistake_;
};

} // namespace openntc_tests
