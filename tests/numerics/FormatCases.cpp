// SPDX-License-Identifier: MIT
// E4M3, binary16 and binary32 networks.
#include "Decoders.h"
#include "HardCases.h"
#include "models/FP8Interval.h"
#include "models/NumberFormats.h"

#include "openntc/core/E4M3.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace numerics {

namespace {

using namespace openntc;

conformance::EditableSet MakeFP8Set(std::uint32_t seed) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {14, 11, 16, 2};
    synthesis.shape = {2, 4, 16, 4, 8};
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    synthesis.withFP8 = true;
    return conformance::SynthesizeEditableSet(synthesis);
}

double ModelE4M3(unsigned code) {
    return models::E4M3Value(static_cast<std::byte>(code));
}

// All products of two E4M3 numbers are exact in binary32, so only the order of additions is left open; and rounding to
// E4M3 of every half equals scaling and rounding in double precision.
Measurement MeasureE4M3() {
    double worst = 0;
    for (unsigned a = 0; a < 256; ++a) {
        for (unsigned b = 0; b < 256; ++b) {
            if ((a & 127) == 127 || (b & 127) == 127)
                continue; // NaN: refused at load
            const float product =
                E4M3ToFloat(static_cast<std::uint8_t>(a)) * E4M3ToFloat(static_cast<std::uint8_t>(b));
            worst = std::max(worst, std::fabs(static_cast<double>(product) - ModelE4M3(a) * ModelE4M3(b)));
        }
    }
    for (unsigned code = 0; code < 0x7C00; ++code) {
        const double value = models::HalfValue(static_cast<std::uint16_t>(code));
        const float rounded = E4M3ToFloat(FloatToE4M3(static_cast<float>(value)));
        worst = std::max(worst, std::fabs(static_cast<double>(rounded) - conformance::RoundToE4M3(value)));
    }
    return {worst, "255 x 255 products, 31744 conversions"};
}

// Every weight code but NaN, inputs that saturate (level of detail 600) and subnormal ones.
Measurement MeasureFP8Network() {
    double worst = 0;
    for (const float lod : {0.0f, 600.0f, -1000.0f, 0.003f}) {
        conformance::EditableSet set = MakeFP8Set(31);
        const NetworkDescription network = GetNetworkDescription(NTC_NETWORK_SMALL);
        std::span<std::byte> weights = set.weights.fp8.AsSpan();
        unsigned code = 0;
        for (int i = network.weightOffsets[0]; i < network.weightOffsets[1]; i += 7) {
            code = (code + 89) & 255;
            weights[static_cast<std::size_t>(i)] = static_cast<std::byte>((code & 127) == 127 ? 0 : code);
        }
        for (ColorMip& mip : set.mips)
            mip.positionLod = lod;
        const TestSet written(conformance::WriteSet(set));
        worst = std::max(worst, Compare(written, DecodeMath::FP8, written.ListTexels(3)));
    }
    return {worst, {}};
}

// How far FP8 hardware may be from the emulation: half the width of the interval of FP8Interval.h, in units of 1/255.
// The worst error is how far the emulation is outside it.
Measurement MeasureFP8Order() {
    const models::FP8Interval interval;
    const TestSet set(conformance::WriteSet(MakeFP8Set(32)));
    const tool::DecodeData data = set.GetData(DecodeMath::FP8);
    const models::ModelSource source{&data.constants, data.latents, data.weights, data.networkVersion};
    std::vector<double> widths;
    double outside = 0;
    for (const Texel& texel : set.ListTexels(2)) {
        const Outputs values = set.GetExpected(DecodeMath::FP8, false, texel);
        const auto bounds = interval.Decode(source, texel.mip, texel.x, texel.y);
        for (std::size_t c = 0; c < 16; ++c) {
            const double value = static_cast<double>(values[c]);
            outside = std::max({outside, bounds[c].low - value, value - bounds[c].high});
            widths.push_back(255 * (bounds[c].high - bounds[c].low) / 2);
        }
    }
    std::sort(widths.begin(), widths.end());
    char note[120];
    std::snprintf(note, sizeof note,
                  "half width in 1/255 on a synthesised set: median %.3g, p99 %.3g, largest %.3g",
                  widths[widths.size() / 2], widths[widths.size() * 99 / 100], widths.back());
    return {outside, note};
}

/// In units of 1/255, ascending.
struct Widths {
    std::vector<double> half;      ///< half the widths of the intervals
    std::vector<double> emulation; ///< how far a result inside may be from the emulation
};

/// Of every `stride`-th texel.
Widths ListWidths(const TestSet& set, const models::FP8Interval& interval, std::size_t stride) {
    const tool::DecodeData data = set.GetData(DecodeMath::FP8);
    const models::ModelSource source{&data.constants, data.latents, data.weights, data.networkVersion};
    const std::uint32_t channels = set.GetMetadata().GetValidChannelMask();
    Widths widths;
    for (const Texel& texel : set.ListTexels(stride)) {
        const auto bounds = interval.Decode(source, texel.mip, texel.x, texel.y);
        const auto emulated = models::DecodeFP8Model(source, texel.mip, texel.x, texel.y);
        for (std::size_t c = 0; c < 16; ++c) {
            if ((channels >> c & 1) == 0)
                continue;
            widths.half.push_back(255 * (bounds[c].high - bounds[c].low) / 2);
            widths.emulation.push_back(255 *
                                       std::max(bounds[c].high - emulated[c], emulated[c] - bounds[c].low));
        }
    }
    std::sort(widths.half.begin(), widths.half.end());
    std::sort(widths.emulation.begin(), widths.emulation.end());
    return widths;
}

Measurement MeasureHalfNetwork() {
    const TestSet set(conformance::WriteSet(MakeFP8Set(33)));
    return {Compare(set, DecodeMath::FP16, set.ListTexels(5)), {}};
}

Measurement MeasureRealNetwork() {
    const TestSet set(conformance::WriteSet(MakeFP8Set(34)));
    return {Compare(set, DecodeMath::FP32, set.ListTexels(5)), {}};
}

constexpr HardCase kFormatCases[] = {
    {"e4m3-products",
     "Products of all pairs of E4M3 numbers, and rounding of every half to E4M3 with subnormals and "
     "saturation.",
     "Emulations that flush subnormals (LibNTC's CUDA path before SM 8.9) or overflow to NaN.",
     "Seven significant bits times eight fit binary32; rounding is nearest even and saturates at 448.", 0,
     MeasureE4M3},
    {"fp8-network", "FP8 networks with every weight code, inputs beyond 448 and below 2^-6.",
     "Non-saturating conversions; lost subnormals.", "The same integer operations in every language.", 0,
     MeasureFP8Network},
    {"fp8-accumulation-order",
     "Hardware adds products in an order and width of its own. The worst error is how far results leave the "
     "interval "
     "derived for any order.",
     "Cooperative vectors with FP8 weights, LibNTC's tensor-core decoder. NVIDIA's driver for an H100 widens "
     "E4M3 weights to binary16, does not round activations to E4M3, and keeps sums in binary16 between "
     "blocks of "
     "16 inputs (docs/benchmarks/fp8-intervals.md).",
     "Cannot be fixed by a format; the emulation is one defined order inside the interval. Stable "
     "alternative: INT8, which "
     "every generation-1 file with Int8 weights has.",
     0, MeasureFP8Order},
    {"fp16-network", "Sums in binary16 depend on their order.", "Vectorised or fused half arithmetic.",
     "The order is part of the maths mode's definition.", 0, MeasureHalfNetwork},
    {"fp32-network", "Sums in binary32 depend on their order and on contraction.",
     "Compilers, vectorised sums.", "The order is part of the maths mode's definition; no contraction.", 0,
     MeasureRealNetwork},
};

} // namespace

std::span<const HardCase> ListFormatCases() {
    return kFormatCases;
}

// A report, not a test: the table of docs/benchmarks/fp8-intervals.md.
TEST_CASE("FP8 intervals of real sets") {
    const char* path = std::getenv("OPENNTC_WRITE_FP8_INTERVALS");
    if (path == nullptr) {
        MESSAGE("SKIP: FP8 intervals of real sets: minutes, for a page of the documentation; name it in "
                "OPENNTC_WRITE_FP8_INTERVALS");
        return;
    }
    const char* shared = std::getenv("OPENNTC_SHARED_DIR");
    std::vector<std::filesystem::path> files;
    for (const std::string& folder : {std::string(shared != nullptr ? shared : "") + "/conformance",
                                      std::string(OPENNTC_DOCS_DIR) + "/../examples/materials/data"}) {
        std::error_code error;
        for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
            const std::string name = entry.path().filename().string();
            if (entry.path().extension() == ".ntc" && name.rfind("v09", 0) != 0)
                files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    std::ofstream table(path);
    struct {
        const char* name;
        models::FP8Assumptions assumptions;
    } const kAssumptions[] = {
        {"binary32, any activation", {.branches = 256}},
        {"binary32", {.contraction = false, .branches = 256}},
        {"H100", {.halfInputs = true, .block = 16, .contraction = false, .branches = 256}},
        {"14 bits, any order", {.unit = 0x1p-13, .contraction = false}},
        {"binary16, any order", {.unit = 0x1p-11, .contraction = false}},
    };
    table
        << "| set | outputs | sums | median | 99th percentile | largest | from the emulation: median | 99th "
           "percentile | largest |\n|---|---|---|---|---|---|---|---|---|\n";
    for (const std::filesystem::path& file : files) {
        std::ifstream input(file, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(input), std::istreambuf_iterator<char>()};
        const auto bytes = std::as_bytes(std::span(text));
        const TestSet set({bytes.begin(), bytes.end()});
        if (!set.GetMetadata().IsInferenceWeightTypeSupported(InferenceWeightType::GenericFP8))
            continue;
        const std::size_t texels = static_cast<std::size_t>(set.GetMetadata().GetDesc().width) *
                                   static_cast<std::size_t>(set.GetMetadata().GetDesc().height) * 4 / 3;
        for (const auto& [name, assumptions] : kAssumptions) {
            const models::FP8Interval interval(assumptions);
            const Widths widths = ListWidths(set, interval, std::max<std::size_t>(texels / 1000, 1));
            const std::size_t count = widths.half.size();
            char line[320];
            std::snprintf(line, sizeof line, "| %s | %zu | %s | %.3g | %.3g | %.3g | %.3g | %.3g | %.3g |\n",
                          file.stem().string().c_str(), count, name, widths.half[count / 2],
                          widths.half[count * 99 / 100], widths.half.back(), widths.emulation[count / 2],
                          widths.emulation[count * 99 / 100], widths.emulation.back());
            table << line << std::flush;
        }
    }
}

} // namespace numerics
