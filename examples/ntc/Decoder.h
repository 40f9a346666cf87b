// SPDX-License-Identifier: MIT
// One interface over the decoders that `--backend` chooses from.
#pragma once

#include "TextureSet.h"

#include "openntc/decode/DecodeTypes.h"
#include "openntc/inference/SliceLayout.h"

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace openntc {
enum class SimdTarget; // of FastDecoder.h, which is slow to compile
}

namespace openntc::tool {

enum class Backend { Cpu, Reference, Vulkan };

struct BackendOptions {
    Backend backend = Backend::Cpu;
    std::string device;    ///< for Vulkan: index or part of a name; empty: a GPU if there is one
    SimdTarget simd{};     ///< for Cpu: SimdTarget::Best
    int threads = 0;       ///< for Cpu: 0 is all
    bool matrices = false; ///< for Vulkan: cooperative matrices, with the bits of int8 and int8_half
};

struct DecodeData;

/// Decodes rectangles of one texture set with one back end.
class Decoder {
public:
    virtual ~Decoder() = default;

    /// 16 values a texel, row by row. `rect` is inside the mip.
    virtual Expected<void> Decode(int mip, Rect rect, const DecodeOptions& options,
                                  std::span<float> outputs) = 0;

    /// Takes another set, which must outlive the decoder, and keeps what is slow to prepare (pipelines). False if this
    /// back end has nothing to keep: make a new decoder.
    virtual Expected<bool> Rebind(const DecodeData&) { return false; }

    /// Edge of a square of texels that is worth decoding at once when only some of its texels are wanted.
    virtual int GetTileSize() const { return 8; }

    /// Seconds on the device of the last Decode, where the device has a clock.
    virtual std::optional<double> GetDeviceSeconds() const { return std::nullopt; }

    /// Device and driver, or empty for the CPU.
    virtual std::string GetDeviceName() const { return {}; }
};

/// What decoders read, kept alive beside them: constants for all mips, latents, weights.
struct DecodeData {
    NtcTextureSetConstants constants;
    std::vector<std::byte> latents;
    std::vector<std::byte> weights;
    int networkVersion = 0;
    DecodeMath math = DecodeMath::Int8; ///< the weights are those that it reads

    DecodeSource GetSource() const {
        return {&constants, latents, weights, networkVersion, GetDecodeWeights(math)};
    }
};

/// All but latents: constants of all mips and the weights that `math` reads. Throws CommandError(BadInput) if the set has none.
DecodeData PrepareDecodeData(const TextureSetMetadata& metadata, const std::string& name,
                             DecodeMath math = DecodeMath::Int8);

/// With the weights that `math` reads. Throws CommandError(BadInput) if the set has none.
DecodeData LoadDecodeData(TextureSet& set, DecodeMath math = DecodeMath::Int8);

/// The same of a set in any stream; `name` is that of errors.
DecodeData LoadDecodeData(const TextureSetMetadata& metadata, Stream& stream, const std::string& name,
                          DecodeMath math = DecodeMath::Int8);

/// The same with the latents of a slice alone.
DecodeData LoadSliceData(TextureSet& set, DecodeMath math, const SliceDesc& slice);

/// The mode that was asked for, if any; else Int8, or, which `warn` is told, FP8 of a set that has no Int8 weights.
DecodeMath ChooseMath(const TextureSet& set, std::optional<DecodeMath> asked,
                      const std::function<void(const std::string&)>& warn);

/// `data` must outlive the decoder. On the CPU the maths modes without a fast form use the reference decoder, unless an
/// instruction set is asked for. Errors: Status::Unsupported if the device or instruction set is absent.
Expected<std::unique_ptr<Decoder>> MakeDecoder(const DecodeData& data, const BackendOptions& options);

/// The same, with the set's name: throws CommandError(NoDevice) if a device is absent, CommandError(Usage) for matrices on
/// another back end than Vulkan.
std::unique_ptr<Decoder> RequireDecoder(const std::string& subject, const DecodeData& data,
                                        const BackendOptions& options);

/// Instruction sets that the fast decoder has code for, slowest first, with their names.
std::span<const std::pair<SimdTarget, const char*>> ListSimdTargets();

const char* GetName(Backend backend);
const char* GetName(DecodeMath math);
/// The name that `--math` has for it.
const char* GetName(DecodeMath math, const BackendOptions& options);

} // namespace openntc::tool
