// SPDX-License-Identifier: MIT
#include "Python.h"

#include "encode/Training.h"

#include "openntc/image/ColorEncoding.h"

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
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
    int bits;         ///< 8, 16, or 32 for floats in linear light
    bool isSrgb;      ///< of 8 or 16 bits: how the values are to be understood
    bool isNormalMap; ///< mips are unit vectors
    float weight;     ///< of errors in training
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
    throw py::value_error(text);
}

encode::MaterialTexture Describe(const TextureInput& input, int firstChannel) {
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

encode::Material MakeMaterial(const std::vector<TextureInput>& inputs, int mips,
                              encode::EncodeOptions& options) {
    if (inputs.empty())
        throw py::value_error("textures: none: must be at least one");
    const py::ssize_t height = inputs[0].texels.shape(0), width = inputs[0].texels.shape(1);
    constexpr py::ssize_t kLimit = encode::Material::kMaxSize;
    encode::Material material = Unwrap(encode::Material::Create(
        static_cast<int>(std::min(width, kLimit + 1)), static_cast<int>(std::min(height, kLimit + 1))));
    int channel = 0;
    for (const TextureInput& input : inputs) {
        if (input.texels.shape(0) != height || input.texels.shape(1) != width)
            throw py::value_error(input.name + ": " + std::to_string(input.texels.shape(1)) + " x " +
                                  std::to_string(input.texels.shape(0)) + ": must be " +
                                  std::to_string(width) + " x " + std::to_string(height) +
                                  " as the first texture");
        const encode::MaterialTexture texture = Describe(input, channel);
        std::vector<float> texels(input.texels.data(), input.texels.data() + input.texels.size());
        if (input.bits == 32) {
            for (std::size_t i = 0; i < texels.size(); ++i) {
                if (i % static_cast<std::size_t>(texture.channels) != 3)
                    texels[i] = image::EncodeColor(ColorSpace::HLG, texels[i]);
            }
        }
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
            return answer.is_none() || answer.cast<bool>();
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

Outcome Encode(const std::vector<TextureInput>& inputs, const py::dict& settings, const py::object& function,
               const std::string& state) {
    static const std::map<std::string, encode::Effort> kEfforts = {
        {"fast", encode::Effort::Fast}, {"normal", encode::Effort::Normal}, {"best", encode::Effort::Best}};
    static const std::map<std::string, int> kNetworks = {{"small", NTC_NETWORK_SMALL},
                                                         {"medium", NTC_NETWORK_MEDIUM},
                                                         {"large", NTC_NETWORK_LARGE},
                                                         {"xlarge", NTC_NETWORK_XLARGE}};
    encode::EncodeOptions options;
    options.bitsPerPixel = settings["bits_per_pixel"].cast<float>();
    const int generation = settings["generation"].cast<int>();
    if (generation != 1 && generation != 3)
        throw py::value_error("generation: " + std::to_string(generation) + ": must be 1 or 3");
    options.networkVersion = generation == 3
                                 ? NTC_NETWORK_GENERATION_3
                                 : GetNamed(kNetworks, "network", settings["network"].cast<std::string>());
    options.effort = GetNamed(kEfforts, "effort", settings["effort"].cast<std::string>());
    options.steps = settings["steps"].cast<std::uint64_t>();
    options.seconds = settings["seconds"].cast<double>();
    options.seed = settings["seed"].cast<std::uint32_t>();
    options.threads = settings["threads"].cast<int>();
    options.fp8 = settings["fp8"].cast<bool>();
    options.compress = settings["compress"].cast<bool>();
    options.maskChannel = settings["mask_channel"].cast<int>();
    options.resumeState = std::as_bytes(std::span(state));
    options.resumeFraction = settings["resume_fraction"].cast<double>();
    encode::Material material = MakeMaterial(inputs, settings["mips"].cast<int>(), options);

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
                const auto texture = item.cast<py::tuple>();
                inputs.push_back({texture[0].cast<std::string>(), texture[1].cast<Texels>(),
                                  texture[2].cast<int>(), texture[3].cast<bool>(), texture[4].cast<bool>(),
                                  texture[5].cast<float>()});
                if (inputs.back().texels.ndim() != 3 || inputs.back().texels.shape(2) > kMaxChannels)
                    throw py::value_error(inputs.back().name +
                                          ": must be height x width x up to 16 channels");
            }
            return Encode(inputs, settings, progress, state);
        },
        py::arg("textures"), py::arg("settings"), py::arg("progress"), py::arg("state"));
}

} // namespace openntc::python
