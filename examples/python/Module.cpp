// SPDX-License-Identifier: MIT
// The Python module `_openntc`, which the package `openntc` wraps: texture sets in memory.
#include "Python.h"

#include "openntc/container/SchemaFields.h"
#include "openntc/core/FileStream.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace openntc::python {

namespace {

const std::map<std::string, DecodeMath> kMathNames = {{"int8", DecodeMath::Int8},
                                                      {"int8_half", DecodeMath::Int8Half},
                                                      {"fp8", DecodeMath::FP8},
                                                      {"fp16", DecodeMath::FP16},
                                                      {"fp32", DecodeMath::FP32}};

DecodeMath GetMath(const std::string& name) {
    const auto found = kMathNames.find(name);
    if (found == kMathNames.end())
        throw PythonError("math: " + name + ": must be int8, int8_half, fp8, fp16 or fp32");
    return found->second;
}

InferenceWeightType GetWeightType(const std::string& name) {
    if (name != "int8" && name != "fp8")
        throw PythonError("weights: " + name + ": must be int8 or fp8");
    return name == "fp8" ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
}

/// As it is in files: UNORM8, sRGB.
template <typename Enum>
std::string GetEnumName(Enum value) {
    return std::string(container::EnumToString(value));
}

struct TextureEntry {
    std::string name;
    int firstChannel, channels;
    std::string format, colorSpace, alphaColorSpace;
};

/// A file that was read, and what its decoders need, made when it is first asked for.
class LoadedSet {
public:
    explicit LoadedSet(const std::string& path)
        : reader_(std::make_unique<FileReader>(Unwrap(FileReader::Open(path), path))),
          set_(Unwrap(TextureSetMetadata::Load(*reader_), path)) {}

    static std::unique_ptr<LoadedSet> OfBytes(const py::bytes& data) {
        const std::string_view text = data;
        std::vector<std::byte> bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        return std::unique_ptr<LoadedSet>(new LoadedSet(std::move(bytes)));
    }

    const TextureSetMetadata& Get() const { return set_; }

    std::vector<TextureEntry> GetTextures() const {
        std::vector<TextureEntry> entries;
        for (const Texture& texture : set_.GetTextures())
            entries.push_back({std::string(texture.name), texture.firstChannel, texture.numChannels,
                               GetEnumName(texture.channelFormat), GetEnumName(texture.rgbColorSpace),
                               GetEnumName(texture.alphaColorSpace)});
        return entries;
    }

    std::tuple<int, int> GetMipSize(int mip) const {
        CheckMip(mip);
        const ColorMip& color = set_.GetColorMips()[static_cast<std::size_t>(mip)];
        return {color.width, color.height};
    }

    py::array_t<float> Decode(int mip, std::optional<std::array<int, 4>> rectangle, const std::string& math,
                              bool linear, int threads) {
        const auto [width, height] = GetMipSize(mip);
        const std::array<int, 4> all = {0, 0, width, height};
        const auto [left, top, columns, rows] = rectangle.value_or(all);
        if (left < 0 || top < 0 || columns < 1 || rows < 1 || columns > width - left || rows > height - top)
            throw PythonError("rect: (" + std::to_string(left) + ", " + std::to_string(top) + ", " +
                              std::to_string(columns) + ", " + std::to_string(rows) +
                              "): must lie inside the " + std::to_string(width) + " x " +
                              std::to_string(height) + " texels of mip " + std::to_string(mip));
        const DecodeOptions options{GetMath(math), linear};
        const int channels = set_.GetDesc().channels;
        py::array_t<float> result({rows, columns, channels});
        float* const texels = result.mutable_data();
        const py::gil_scoped_release released;
        const DecodeSource source = GetSource(GetDecodeWeights(options.math));
        const auto count = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
        std::vector<float> outputs(count * NTC_MAX_CHANNELS);
        Unwrap(DecodeTexels(source, mip, {left, top, columns, rows}, options, threads, outputs));
        for (std::size_t i = 0; i < count; ++i)
            std::copy_n(outputs.data() + i * NTC_MAX_CHANNELS, channels,
                        texels + i * static_cast<std::size_t>(channels));
        return result;
    }

    py::bytes GetConstants(int firstMip, int mips, const std::string& weights) const {
        const NtcTextureSetConstants constants =
            Unwrap(MakeInferenceData(set_, firstMip, CountMips(firstMip, mips), GetWeightType(weights)));
        return MakeBytes(std::as_bytes(std::span(&constants, 1)));
    }

    py::bytes GetWeights(const std::string& weights) const {
        return MakeBytes(Unwrap(set_.GetInferenceWeights(GetWeightType(weights))));
    }

    py::bytes GetLatents(int firstMip, int mips) {
        std::vector<std::byte> bytes;
        {
            const py::gil_scoped_release released;
            const std::scoped_lock lock(mutex_);
            bytes = ReadMips(firstMip, CountMips(firstMip, mips));
        }
        return MakeBytes(bytes);
    }

    /// The latents of a rectangle and of the mips below it, and constants to decode them with.
    std::tuple<py::bytes, py::bytes> GetSlice(int firstMip, int mips, std::array<int, 4> rectangle,
                                              const std::string& weights) {
        const InferenceWeightType type = GetWeightType(weights);
        const SliceDesc desc{
            firstMip, CountMips(firstMip, mips), {rectangle[0], rectangle[1], rectangle[2], rectangle[3]}};
        std::vector<std::byte> bytes;
        NtcTextureSetConstants constants;
        {
            const py::gil_scoped_release released;
            const std::scoped_lock lock(mutex_);
            bytes.resize(static_cast<std::size_t>(Unwrap(GetPartialLatentBufferSize(set_, desc))));
            constants = Unwrap(MakePartialInferenceData(set_, *reader_, desc, type, bytes)).constants;
        }
        return {MakeBytes(std::as_bytes(std::span(&constants, 1))), MakeBytes(bytes)};
    }

private:
    explicit LoadedSet(std::vector<std::byte> bytes)
        : bytes_(std::move(bytes)), reader_(std::make_unique<ReadOnlyMemoryStream>(bytes_)),
          set_(Unwrap(TextureSetMetadata::Load(*reader_), "bytes")) {}
    void CheckMip(int mip) const {
        if (mip < 0 || mip >= set_.GetDesc().mips)
            throw PythonError("mip: " + std::to_string(mip) + ": the set has " +
                              std::to_string(set_.GetDesc().mips));
    }
    int CountMips(int firstMip, int mips) const {
        CheckMip(firstMip);
        return mips > 0 ? mips : set_.GetDesc().mips - firstMip;
    }
    std::vector<std::byte> ReadMips(int firstMip, int mips) { // mutex_ is held
        std::vector<std::byte> bytes(Unwrap(GetLatentBufferBytes(set_, firstMip, mips)));
        Unwrap(ReadLatents(set_, *reader_, firstMip, mips, bytes));
        return bytes;
    }
    /// What decoders read: made by the first call, and not changed afterwards.
    DecodeSource GetSource(DecodeWeights format) {
        const bool isFP8 = format == DecodeWeights::FP8;
        const auto type = isFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
        const int mips = set_.GetDesc().mips;
        const std::span<const std::byte> weights = Unwrap(set_.GetInferenceWeights(type));
        const std::scoped_lock lock(mutex_);
        std::optional<NtcTextureSetConstants>& constants = constants_[isFP8 ? 1 : 0];
        if (!constants)
            constants = Unwrap(MakeInferenceData(set_, 0, mips, type));
        if (latents_.empty())
            latents_ = ReadMips(0, mips);
        return {&*constants, latents_, weights, set_.GetNetworkVersion(), format};
    }

    std::vector<std::byte> bytes_; // of a set in memory
    std::unique_ptr<Stream> reader_;
    TextureSetMetadata set_;
    std::mutex mutex_; // of the reader, and of what is made once
    std::vector<std::byte> latents_;
    std::array<std::optional<NtcTextureSetConstants>, 2> constants_; // for int8 and fp8
};

} // namespace

} // namespace openntc::python

PYBIND11_MODULE(_openntc, module) {
    using openntc::python::LoadedSet;
    using openntc::python::TextureEntry;
    py::register_exception<openntc::python::PythonError>(module, "Error", PyExc_ValueError);
    py::class_<TextureEntry>(module, "Texture")
        .def_readonly("name", &TextureEntry::name)
        .def_readonly("first_channel", &TextureEntry::firstChannel)
        .def_readonly("channels", &TextureEntry::channels)
        .def_readonly("format", &TextureEntry::format)
        .def_readonly("color_space", &TextureEntry::colorSpace)
        .def_readonly("alpha_color_space", &TextureEntry::alphaColorSpace)
        .def("__repr__", [](const TextureEntry& entry) {
            return "<Texture '" + entry.name + "', " + std::to_string(entry.channels) + " channels from " +
                   std::to_string(entry.firstChannel) + ">";
        });
    py::class_<LoadedSet>(module, "LoadedSet")
        .def(py::init<const std::string&>(), py::arg("path"))
        .def_static("of_bytes", &LoadedSet::OfBytes, py::arg("data"))
        .def_property_readonly("width", [](const LoadedSet& set) { return set.Get().GetDesc().width; })
        .def_property_readonly("height", [](const LoadedSet& set) { return set.Get().GetDesc().height; })
        .def_property_readonly("channels", [](const LoadedSet& set) { return set.Get().GetDesc().channels; })
        .def_property_readonly("mips", [](const LoadedSet& set) { return set.Get().GetDesc().mips; })
        .def_property_readonly("generation", [](const LoadedSet& set) { return set.Get().GetGeneration(); })
        .def_property_readonly(
            "network",
            [](const LoadedSet& set) { return openntc::GetNetworkName(set.Get().GetNetworkVersion()); })
        .def_property_readonly("textures", &LoadedSet::GetTextures)
        .def("mip_size", &LoadedSet::GetMipSize, py::arg("mip"))
        .def("decode", &LoadedSet::Decode, py::arg("mip"), py::arg("rect"), py::arg("math"),
             py::arg("linear"), py::arg("threads"))
        .def("constants", &LoadedSet::GetConstants, py::arg("first_mip"), py::arg("mips"), py::arg("weights"))
        .def("weights", &LoadedSet::GetWeights, py::arg("weights"))
        .def("latents", &LoadedSet::GetLatents, py::arg("first_mip"), py::arg("mips"))
        .def("slice", &LoadedSet::GetSlice, py::arg("first_mip"), py::arg("mips"), py::arg("rect"),
             py::arg("weights"));
    openntc::python::AddEncoding(module);
}
