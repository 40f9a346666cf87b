// SPDX-License-Identifier: MIT
#include "Arguments.h"
#include "Python.h"

#include "encode/Training.h"
#include "encode/TrainingLimits.h"

#include "openntc/image/ColorEncoding.h"

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <string>
#include <vector>

namespace py = pybind11;

namespace openntc::python {

namespace {

using Texels = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// One texture as the package hands it over: height x width x channels stored values.
struct TextureInput {
    std::string name;
    Texels texels;
    int bits = 8;             ///< 8, 16, or 32 for floats in linear light
    bool isSrgb = false;      ///< of 8 or 16 bits: how the values are to be understood
    bool isNormalMap = false; ///< mips are unit vectors
    float weight = 1.0f;      ///< of errors in training
};

struct Outcome {
    encode::EncodeResult result;
    py::bytes file, state;
};

template <typename Value>
Value GetNamed(const std::map<std::string, Value>& values, const char* option, const std::string& name) {
    if (const auto found = values.find(name); found != values.end())
        return found->second;
    std::string text = std::string(option) + ": " + name + ": must be one of";
    for (const auto& [known, value] : values)
        text += " " + known;
    throw PythonError(text);
}

encode::MaterialTexture MakeTexture(const TextureInput& input, int firstChannel) {
    encode::MaterialTexture texture;
    texture.name = input.name;
    texture.firstChannel = firstChannel;
    texture.channels = static_cast<int>(input.texels.shape(2));
    texture.format = input.bits == 32   ? ChannelFormat::FLOAT16
                     : input.bits == 16 ? ChannelFormat::UNORM16
                                        : ChannelFormat::UNORM8;
    texture.rgbColorSpace = input.isSrgb ? ColorSpace::sRGB : ColorSpace::Linear;
    texture.storedRgb = input.bits == 32 ? ColorSpace::HLG : texture.rgbColorSpace;
    return texture;
}

/// Floats become HLG, but for alpha. Errors: numbers that are not finite, and those that HLG takes to infinity.
std::vector<float> GetStoredTexels(const TextureInput& input, std::size_t channels) {
    std::vector<float> texels(input.texels.data(), input.texels.data() + input.texels.size());
    const auto width = static_cast<std::size_t>(input.texels.shape(1));
    for (std::size_t i = 0; input.bits == 32 && i < texels.size(); ++i) {
        const float value = texels[i];
        if (i % channels != 3)
            texels[i] = image::EncodeColor(ColorSpace::HLG, value);
        if (!std::isfinite(texels[i]))
            throw PythonError(input.name + ": " + std::to_string(value) + " at column " +
                              std::to_string(i / channels % width) + ", row " +
                              std::to_string(i / channels / width) + ": must be finite, at most 2.8e37");
    }
    return texels;
}

encode::Material MakeMaterial(const std::vector<TextureInput>& inputs, int mips,
                              encode::EncodeOptions& options) {
    if (inputs.empty())
        throw PythonError("textures: none: must be at least one");
    const py::ssize_t height = inputs[0].texels.shape(0), width = inputs[0].texels.shape(1);
    constexpr py::ssize_t kLimit = encode::Material::kMaxSize;
    encode::Material material = Unwrap(encode::Material::Create(
        static_cast<int>(std::min(width, kLimit + 1)), static_cast<int>(std::min(height, kLimit + 1))));
    int channel = 0;
    for (const TextureInput& input : inputs) {
        if (input.texels.shape(0) != height || input.texels.shape(1) != width)
            throw PythonError(input.name + ": " + std::to_string(input.texels.shape(1)) + " x " +
                              std::to_string(input.texels.shape(0)) + ": must be " + std::to_string(width) +
                              " x " + std::to_string(height) + " as the first texture");
        const encode::MaterialTexture texture = MakeTexture(input, channel);
        const std::vector<float> texels = GetStoredTexels(input, static_cast<std::size_t>(texture.channels));
        Unwrap(material.AddTexture(texture, texels));
        if (input.isNormalMap)
            Unwrap(material.SetNormalMap(channel, std::min(texture.channels, 3)));
        for (int c = 0; c < texture.channels; ++c)
            options.lossScales[static_cast<std::size_t>(channel + c)] = input.weight;
        channel += texture.channels;
    }
    material.GenerateMips(mips);
    return material;
}

/// Calls Python between steps: signals (Ctrl+C), then the user's function, whose exception ends training.
class PythonProgress {
public:
    explicit PythonProgress(py::object function) : function_(std::move(function)) {}

    bool operator()(const encode::Progress& progress) {
        const py::gil_scoped_acquire acquired;
        try {
            if (PyErr_CheckSignals() != 0)
                throw py::error_already_set();
            if (function_.is_none())
                return true;
            const py::object answer = function_(progress);
            return answer.is_none() || GetFlag("progress: returned", answer);
        } catch (...) {
            failure_ = std::current_exception();
            return false;
        }
    }
    void Rethrow() const {
        if (failure_)
            std::rethrow_exception(failure_);
    }

private:
    py::object function_;
    std::exception_ptr failure_;
};

/// (name, texels, bits, srgb, normal_map, weight), as __init__.py makes it.
TextureInput ReadTexture(const py::tuple& texture) {
    TextureInput input;
    input.name = GetText("textures: name", texture[0]);
    input.texels = texture[1].cast<Texels>();
    input.bits = texture[2].cast<int>();
    input.isSrgb = GetFlag(input.name + ": srgb", texture[3]);
    input.isNormalMap = GetFlag(input.name + ": normal_map", texture[4]);
    input.weight =
        static_cast<float>(GetNumber(input.name + ": weight", texture[5], tool::kWeightLimits, false));
    if (input.texels.ndim() != 3 || input.texels.shape(2) > kMaxChannels)
        throw PythonError(input.name + ": must be height x width x up to 16 channels");
    return input;
}

/// Generation 3 has one network, which is not to be named.
int GetNetwork(const py::dict& settings) {
    static const std::map<std::string, int> kNetworks = {{"small", NTC_NETWORK_SMALL},
                                                         {"medium", NTC_NETWORK_MEDIUM},
                                                         {"large", NTC_NETWORK_LARGE},
                                                         {"xlarge", NTC_NETWORK_XLARGE}};
    const py::object generation = settings["generation"], network = settings["network"];
    constexpr tool::NumberLimits kGenerations{1, 3};
    const double number = GetNumber("generation", generation, kGenerations, true);
    if (number == 2)
        throw PythonError("generation: 2: must be 1 or 3");
    if (number == 3 && !network.is_none())
        throw PythonError("network: " + Describe(network) + ": generation 3 has one network");
    if (number == 3)
        return NTC_NETWORK_GENERATION_3;
    return network.is_none() ? NTC_NETWORK_MEDIUM
                             : GetNamed(kNetworks, "network", GetText("network", network));
}

/// How long to train: one of effort, steps and seconds.
void ReadDuration(const py::dict& settings, encode::EncodeOptions& options) {
    static const std::map<std::string, encode::Effort> kEfforts = {
        {"fast", encode::Effort::Fast}, {"normal", encode::Effort::Normal}, {"best", encode::Effort::Best}};
    const py::object effort = settings["effort"];
    if (!effort.is_none())
        options.effort = GetNamed(kEfforts, "effort", GetText("effort", effort));
    options.steps =
        static_cast<std::uint64_t>(GetNumberOrZero("steps", settings["steps"], tool::kStepLimits, true));
    options.seconds = GetNumberOrZero("seconds", settings["seconds"], tool::kSecondLimits, false);
    if (options.steps > 0 && options.seconds > 0.0)
        throw PythonError("seconds: " + Describe(settings["seconds"]) + ": not together with steps");
    if (!effort.is_none() && (options.steps > 0 || options.seconds > 0.0))
        throw PythonError("effort: " + Describe(effort) + ": not together with steps or seconds");
}

encode::EncodeOptions ReadOptions(const py::dict& settings) {
    encode::EncodeOptions options;
    options.bitsPerPixel = static_cast<float>(
        GetNumber("bits_per_pixel", settings["bits_per_pixel"], tool::kBitsPerPixelLimits, false));
    options.networkVersion = GetNetwork(settings);
    ReadDuration(settings, options);
    options.seed = static_cast<std::uint32_t>(GetNumber("seed", settings["seed"], tool::kSeedLimits, true));
    options.threads = static_cast<int>(GetNumber("threads", settings["threads"], tool::kThreadLimits, true));
    options.fp8 = GetFlag("fp8", settings["fp8"]);
    options.compress = GetFlag("compress", settings["compress"]);
    options.maskChannel = settings["mask_channel"].cast<int>();
    options.resumeFraction = settings["resume_fraction"].cast<double>();
    return options;
}

Outcome Encode(const std::vector<TextureInput>& inputs, const py::dict& settings, const py::object& function,
               const std::string& state) {
    const int mips = static_cast<int>(GetNumberOrZero("mips", settings["mips"], tool::kMipLimits, true));
    encode::EncodeOptions options = ReadOptions(settings);
    options.resumeState = std::as_bytes(std::span(state));
    encode::Material material = MakeMaterial(inputs, mips, options);
    Unwrap(tool::CheckWeights(options, material.GetDeclaredChannels()));

    PythonProgress progress(function);
    Outcome outcome;
    {
        const py::gil_scoped_release released;
        outcome.result = Unwrap(tool::Train(std::move(material), options, std::ref(progress)));
    }
    progress.Rethrow();
    outcome.file = MakeBytes(outcome.result.file);
    outcome.state = MakeBytes(outcome.result.state);
    return outcome;
}

} // namespace

void AddEncoding(py::module_& module) {
    py::class_<encode::Progress>(module, "Progress")
        .def_readonly("step", &encode::Progress::step)
        .def_readonly("steps", &encode::Progress::steps)
        .def_readonly("fraction", &encode::Progress::fraction)
        .def_readonly("psnr", &encode::Progress::psnr)
        .def_readonly("seconds", &encode::Progress::seconds)
        .def_readonly("seconds_left", &encode::Progress::secondsLeft);
    py::class_<Outcome>(module, "Outcome")
        .def_readonly("data", &Outcome::file)
        .def_readonly("state", &Outcome::state)
        .def_property_readonly("psnr", [](const Outcome& outcome) { return outcome.result.psnr; })
        .def_property_readonly("mip_psnr", [](const Outcome& outcome) { return outcome.result.mipPsnr; })
        .def_property_readonly("steps", [](const Outcome& outcome) { return outcome.result.steps; })
        .def_property_readonly("seconds", [](const Outcome& outcome) { return outcome.result.seconds; })
        .def_property_readonly("kernel", [](const Outcome& outcome) { return outcome.result.kernel; })
        .def_property_readonly("cancelled", [](const Outcome& outcome) { return outcome.result.cancelled; })
        .def_property_readonly("fraction", [](const Outcome& outcome) { return outcome.result.fraction; });
    module.def(
        "encode",
        [](const py::list& textures, const py::dict& settings, const py::object& progress,
           const py::bytes& state) {
            std::vector<TextureInput> inputs;
            for (const py::handle& item : textures) {
                inputs.push_back(ReadTexture(item.cast<py::tuple>()));
            }
            return Encode(inputs, settings, progress, state);
        },
        py::arg("textures"), py::arg("settings"), py::arg("progress"), py::arg("state"));
}

} // namespace openntc::python
