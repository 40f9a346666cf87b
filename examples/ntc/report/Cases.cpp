// SPDX-License-Identifier: MIT
#include "report/Cases.h"

#include "Decoder.h"
#include "Output.h"
#include "report/Generations.h"

#include "openntc/InferenceConstants.h"
#include "openntc/MathModes.h"
#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <array>
#include <span>

namespace openntc::report {

namespace {

constexpr const char* kMathNames[] = {"int8",        "int8_half",    "fp8",
                                      "fp16",        "fp32",         "coopvec_int8",
                                      "coopvec_fp8", "coopmat_int8", "coopmat_int8_half"};
constexpr const char* kWeightsNames[] = {"default", "direct", "wide", "wide, 2 texels", "subgroup, float"};

/// A line through a base point: the values that one member takes.
struct Axis {
    const char* name;
    void (*apply)(Case&, double value);
    std::vector<double> values;
    std::vector<double> quickValues;
};

const std::vector<Axis>& ListAxes() {
    static const std::vector<Axis> kAxes = {
        {"maths",
         [](Case& c, double v) { c.math = static_cast<int>(v); },
         {1, 2, 3, 4, 5, 6, 7, 8, 9},
         {1, 2, 3, 5, 6, 7, 8}},
        {"network", [](Case& c, double v) { c.network = static_cast<int>(v); }, {1, 2, 3, 4}, {1, 2, 4}},
        {"bits per pixel", [](Case& c, double v) { c.bitsPerPixel = v; }, {2, 4, 6, 8}, {2, 4, 8}},
        {"outputs, stored",
         [](Case& c, double v) { c.outputs = static_cast<int>(v); },
         {1, 3, 9, 16},
         {1, 9, 16}},
        {"outputs, linear",
         [](Case& c, double v) {
             c.outputs = static_cast<int>(v);
             c.linear = true;
         },
         {1, 3, 9, 16},
         {9}},
        {"sets per workgroup", [](Case& c, double v) { c.sets = static_cast<int>(v); }, {1, 2, 4, 8}, {1, 8}},
        {"weight fetch",
         [](Case& c, double v) { c.weights = static_cast<WeightsForm>(static_cast<int>(v)); },
         {0, 1, 2, 3, 4},
         {}},
    };
    return kAxes;
}

/// Where lines start: the base point, and the same with cooperative vectors, for devices that have them.
std::vector<Case> ListBases() {
    Case vectors;
    vectors.math = NTC_MATH_COOPVEC_INT8;
    return {Case{}, vectors};
}

void Add(std::vector<Case>& cases, Case c, const char* axis) {
    const std::string id = c.GetId();
    auto found =
        std::find_if(cases.begin(), cases.end(), [&](const Case& other) { return other.GetId() == id; });
    if (found == cases.end())
        found = cases.insert(cases.end(), std::move(c));
    if (std::find(found->axes.begin(), found->axes.end(), axis) == found->axes.end())
        found->axes.push_back(axis);
}

/// The generations at equal bits per pixel: every maths mode, INT8 at other sizes, and with every instruction set.
void AddGenerations(std::vector<Case>& cases, bool quick) {
    constexpr double kBitsPerPixel = 5; // which generations 1 and 3 both have a shape of, as 2.5 and 10
    for (const int network : {NTC_NETWORK_MEDIUM, NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        Case c;
        c.network = network;
        c.bitsPerPixel = kBitsPerPixel;
        for (c.math = NTC_MATH_INT8; c.math <= (quick ? NTC_MATH_INT8 : kMathCount); ++c.math)
            Add(cases, c, kGenerationAxis);
        c.math = NTC_MATH_INT8;
        for (c.instructions = static_cast<int>(tool::ListSimdTargets().size()); c.instructions > 0;
             --c.instructions)
            Add(cases, c, kGenerationAxis);
        for (const double bits : {2.5, 10.0}) {
            c.bitsPerPixel = bits;
            if (!quick)
                Add(cases, c, kGenerationAxis);
        }
        c.bitsPerPixel = kBitsPerPixel;
        c.latentTexture = true;
        for (const int math : {NTC_MATH_INT8, NTC_MATH_FP8}) {
            c.math = math;
            if (!IsNetworkVersion(network) && !(quick && math != NTC_MATH_INT8))
                Add(cases, c, kGenerationAxis);
        }
    }
}

// Values of maths and network run from low to high, whatever line came first.
void Sort(std::vector<Case>& cases) {
    std::stable_sort(cases.begin(), cases.end(), [](const Case& a, const Case& b) {
        return std::pair(a.network, a.math) < std::pair(b.network, b.math);
    });
}

} // namespace

std::vector<Case> ListCases(bool quick, const std::string& modelMaterial) {
    std::vector<Case> cases;
    for (const Case& base : ListBases()) {
        for (const Axis& axis : ListAxes()) {
            for (const double value : quick ? axis.quickValues : axis.values) {
                Case c = base;
                axis.apply(c, value);
                Add(cases, c, axis.name);
            }
        }
    }
    for (int math = NTC_MATH_INT8; !quick && math <= NTC_MATH_COOPMAT_INT8_HALF; ++math) {
        for (int network = NTC_NETWORK_SMALL; network <= NTC_NETWORK_XLARGE; ++network) {
            Case c;
            c.math = math;
            c.network = network;
            Add(cases, c, "maths x network");
        }
    }
    AddGenerations(cases, quick);
    if (!quick && !modelMaterial.empty()) {
        // LibNTC's figures, which the page shows beside these, use a larger network for more bits.
        constexpr std::pair<int, double> kSizes[] = {
            {NTC_NETWORK_SMALL, 2}, {NTC_NETWORK_MEDIUM, 4}, {NTC_NETWORK_XLARGE, 8}};
        for (const auto& [network, bits] : kSizes) {
            Case c;
            c.material = modelMaterial;
            c.network = network;
            c.bitsPerPixel = bits;
            Add(cases, c, "bits per pixel");
        }
    }
    Sort(cases);
    return cases;
}

std::string Case::GetId() const {
    std::string id = GetEncodingName(*this) + " " + GetMathName(math) +
                     tool::Format(" %d outputs ", outputs) + (linear ? "linear" : "stored");
    if (sets > 0)
        id += tool::Format(" %d sets", sets);
    if (weights != WeightsForm::Default)
        id += std::string(" weights: ") + GetWeightsName(weights);
    if (instructions > 0)
        id += std::string(" on ") + GetInstructionsName(instructions);
    if (latentTexture)
        id += " latents in a texture";
    return id;
}

const char* GetMathName(int math) {
    return math >= 1 && math <= kMathCount ? kMathNames[math - 1] : "?";
}

bool UsesMatrices(int math) {
    return math == NTC_MATH_COOPMAT_INT8 || math == NTC_MATH_COOPMAT_INT8_HALF;
}

const char* GetWeightsName(WeightsForm weights) {
    return kWeightsNames[static_cast<int>(weights)];
}

const char* GetInstructionsName(int instructions) {
    return instructions > 0 ? tool::ListSimdTargets()[static_cast<std::size_t>(instructions - 1)].second : "";
}

std::string GetEncodingName(const Case& c) {
    return c.material + "-" + GetNetworkName(c.network) + tool::Format("-%gbpp", c.bitsPerPixel);
}

} // namespace openntc::report
