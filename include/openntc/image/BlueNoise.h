// SPDX-License-Identifier: MIT
// Stability: experimental
// Blue noise over pixels and frames, for stochastic texture filtering (docs/filtering.md): void and cluster
// (Ulichney 1993), with energy between texels of one frame and between frames of one texel only (Wolfe and
// others 2022). In integers: the same noise everywhere.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::image {

/// size x size texels that repeat, in `slices` frames that repeat. Seeds give different noise, for different
/// uses.
struct BlueNoiseDesc {
    int size = 32;   ///< 8 ... 128
    int slices = 16; ///< 1 ... 64; size * size * slices at most 262144
    std::uint32_t seed = 1;
};

namespace detail {

class BlueNoiseMaker {
public:
    BlueNoiseMaker(const BlueNoiseDesc& desc, Allocator& allocator)
        : desc_(desc), energies_(allocator), kernel_(allocator), ones_(allocator), start_(allocator),
          ranks_(allocator) {}

    Expected<void> Make(Array<std::uint16_t>& noise) {
        slice_ = Number(desc_.size) * Number(desc_.size);
        count_ = slice_ * Number(desc_.slices);
        OPENNTC_CHECK(energies_.Resize(count_));
        OPENNTC_CHECK(ones_.Resize(count_));
        OPENNTC_CHECK(ranks_.Resize(count_));
        OPENNTC_CHECK(noise.Resize(count_));
        OPENNTC_CHECK(kernel_.Resize(slice_ + Number(desc_.slices)));
        MakeKernel();
        ScatterOnes();
        SettleOnes();
        OPENNTC_CHECK(start_.Assign(ones_.AsSpan()));
        // Ranks below the start: tightest clusters, removed one by one; above it: largest voids, filled.
        for (std::size_t rank = number_; rank > 0; --rank) {
            const std::size_t at = FindTightest();
            Set(at, false);
            ranks_[at] = static_cast<std::uint32_t>(rank - 1);
        }
        for (std::size_t i = 0; i < count_; ++i) {
            if (start_[i] != 0)
                Set(i, true);
        }
        for (std::size_t rank = number_; rank < count_; ++rank) {
            const std::size_t at = FindVoid();
            Set(at, true);
            ranks_[at] = static_cast<std::uint32_t>(rank);
        }
        return RankSlices(noise);
    }

private:
    static std::size_t Number(int value) { return static_cast<std::size_t>(value); }

    /// exp(-d^2 / 2 sigma^2) with sigma = 1.9 in 2^-24: within a slice by x and y, then by slices apart.
    void MakeKernel() {
        const auto get = [](int square) {
            return static_cast<std::uint32_t>(std::lround(std::exp(-square / (2 * 1.9 * 1.9)) * 16777216.0));
        };
        const auto distance = [](int a, int period) { return a <= period / 2 ? a : period - a; };
        for (int y = 0; y < desc_.size; ++y) {
            for (int x = 0; x < desc_.size; ++x) {
                const int dx = distance(x, desc_.size), dy = distance(y, desc_.size);
                kernel_[Number(y * desc_.size + x)] = get(dx * dx + dy * dy);
            }
        }
        for (int z = 0; z < desc_.slices; ++z) {
            const int dz = distance(z, desc_.slices);
            kernel_[slice_ + Number(z)] = z == 0 ? 0 : get(dz * dz); // itself is counted in its slice
        }
    }

    /// One texel in ten, by a permuted congruential generator.
    void ScatterOnes() {
        std::uint32_t state = desc_.seed * 747796405u + 1u;
        while (number_ < count_ / 10) {
            state = state * 747796405u + 2891336453u;
            const std::uint32_t word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
            const std::size_t at = ((word >> 22) ^ word) % count_;
            if (ones_[at] == 0) {
                Set(at, true);
                ++number_;
            }
        }
    }

    /// The tightest cluster moves into the largest void until that is where it came from.
    void SettleOnes() {
        for (std::size_t turn = 0; turn < 4 * count_; ++turn) {
            const std::size_t from = FindTightest();
            Set(from, false);
            const std::size_t to = FindVoid();
            Set(to, true);
            if (to == from)
                return;
        }
    }

    void Set(std::size_t at, bool isOne) {
        ones_[at] = isOne ? 1 : 0;
        const std::uint32_t sign = isOne ? 1u : ~0u; // -1, modulo 2^32
        const std::size_t size = Number(desc_.size), z = at / slice_, x = at % size, y = at % slice_ / size;
        for (std::size_t row = 0; row < size; ++row) {
            const std::uint32_t* const kernel = kernel_.data() + (row + size - y) % size * size;
            std::uint32_t* const energies = energies_.data() + z * slice_ + row * size;
            for (std::size_t column = 0; column < size; ++column)
                energies[column] += sign * kernel[(column + size - x) % size];
        }
        const std::size_t slices = Number(desc_.slices);
        for (std::size_t other = 0; other < slices; ++other)
            energies_[other * slice_ + at % slice_] += sign * kernel_[slice_ + (other + slices - z) % slices];
    }

    /// The lowest of ones with the largest energy.
    std::size_t FindTightest() const {
        std::size_t best = 0;
        std::uint32_t most = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            if (ones_[i] != 0 && energies_[i] > most) {
                most = energies_[i];
                best = i;
            }
        }
        return best;
    }

    /// The lowest of zeros with the smallest energy.
    std::size_t FindVoid() const {
        std::size_t best = 0;
        std::uint32_t least = ~0u;
        for (std::size_t i = 0; i < count_; ++i) {
            if (ones_[i] == 0 && energies_[i] < least) {
                least = energies_[i];
                best = i;
            }
        }
        return best;
    }

    /// Each slice ranked on its own, as 16 bits: every slice has the same numbers. By counting, since all
    /// ranks differ: texels in the order of their rank.
    Expected<void> RankSlices(Array<std::uint16_t>& noise) {
        Array<std::uint32_t> order(energies_.GetAllocator());
        OPENNTC_CHECK(order.Resize(count_));
        for (std::size_t i = 0; i < count_; ++i)
            order[ranks_[i]] = static_cast<std::uint32_t>(i);
        for (std::size_t z = 0; z < Number(desc_.slices); ++z) {
            std::uint64_t rank = 0;
            for (const std::uint32_t at : order.AsSpan()) {
                if (at / slice_ == z)
                    noise[at] = static_cast<std::uint16_t>((2 * rank++ + 1) * 32768 / slice_);
            }
        }
        return {};
    }

    BlueNoiseDesc desc_;
    std::size_t slice_ = 0, count_ = 0, number_ = 0;
    Array<std::uint32_t> energies_, kernel_;
    Array<std::uint8_t> ones_, start_;
    Array<std::uint32_t> ranks_;
};

} // namespace detail

/// Noise of 16 bits, slice by slice and row by row. Makes 32 x 32 x 16 in a fraction of a second, but
/// 64 x 64 x 32 in most of a minute: to be kept. Errors: OutOfRange, naming the field; OutOfMemory.
inline Expected<Array<std::uint16_t>> MakeBlueNoise(const BlueNoiseDesc& desc,
                                                    Allocator& allocator = GetDefaultAllocator()) {
    if (desc.size < 8 || desc.size > 128)
        return Fail(Status::OutOfRange, "blue noise: size %d is not 8 to 128", desc.size);
    if (desc.slices < 1 || desc.slices > 64)
        return Fail(Status::OutOfRange, "blue noise: slices %d is not 1 to 64", desc.slices);
    if (desc.size * desc.size * desc.slices > 262144)
        return Fail(Status::OutOfRange, "blue noise: %d x %d x %d texels are more than 262144", desc.size,
                    desc.size, desc.slices);
    Array<std::uint16_t> noise(allocator);
    detail::BlueNoiseMaker maker(desc, allocator);
    OPENNTC_CHECK(maker.Make(noise));
    return noise;
}

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
