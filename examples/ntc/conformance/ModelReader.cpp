// SPDX-License-Identifier: MIT
// The model's own reader of files. Numbers in brackets are sections of the format specification's container document.
#include "ModelSet.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>

namespace openntc::conformance {

namespace {

using rapidjson::Value;

struct View {
    std::size_t offset; // of the file
    std::size_t size;
};

template <typename T>
T LoadAt(std::span<const std::byte> bytes, std::size_t at) {
    T value{};
    if (at > bytes.size() || bytes.size() - at < sizeof value)
        throw std::runtime_error("model: the file is too short");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::int32_t ToSaturatedInt(double value) {
    if (std::isnan(value))
        return 0;
    return static_cast<std::int32_t>(
        std::clamp(value, static_cast<double>(std::numeric_limits<std::int32_t>::min()),
                   static_cast<double>(std::numeric_limits<std::int32_t>::max())));
}

class FileReaderOfModel {
public:
    FileReaderOfModel(std::span<const std::byte> file, Mistake mistake) : file_(file), mistake_(mistake) {}

    ModelSet Read() {
        ReadDocument();
        ModelSet set;
        set.file = file_;
        set.width = GetInt(root_, "width");
        set.height = GetInt(root_, "height");
        set.channels = GetInt(root_, "numChannels");
        set.generation = GetInt(root_, "schemaVersion");
        ReadNetworks(set);
        ReadChannels(set);
        if (set.generation == 1)
            ReadImages(set);
        else
            ReadLatentMips(set);
        ReadMips(set);
        return set;
    }

private:
    bool Makes(Mistake mistake) const { return mistake_ == mistake; }

    void ReadDocument() { // [1]
        const auto jsonOffset = static_cast<std::size_t>(LoadAt<std::uint64_t>(file_, 8));
        const auto jsonSize = static_cast<std::size_t>(LoadAt<std::uint64_t>(file_, 16));
        auto binary = static_cast<std::size_t>(LoadAt<std::uint64_t>(file_, 24));
        if (Makes(Mistake::BinaryBehindJson))
            binary = (jsonOffset + jsonSize + 3) / 4 * 4;
        std::string text(reinterpret_cast<const char*>(file_.data()) + jsonOffset, jsonSize);
        text = text.c_str(); // text behind the first NUL is ignored
        root_.Parse<rapidjson::kParseFullPrecisionFlag>(text.c_str(), text.size());
        if (root_.HasParseError() || !root_.IsObject())
            throw std::runtime_error("model: JSON: syntax error");
        std::size_t sum = 0;
        ForEach(root_, "views", [&](const Value& view) {
            const auto size = static_cast<std::size_t>(view["storedSize"].GetUint64());
            const auto offset = static_cast<std::size_t>(view["offset"].GetUint64());
            views_.push_back({binary + (Makes(Mistake::SequentialViews) ? sum : offset), size});
            sum += (size + 3) / 4 * 4;
        });
    }

    static const Value* Find(const Value& object, const char* key) {
        const auto member = object.FindMember(key);
        return member == object.MemberEnd() ? nullptr : &member->value;
    }
    static int GetInt(const Value& object, const char* key) {
        const Value* value = Find(object, key);
        if (value == nullptr || !value->IsUint())
            throw std::runtime_error(std::string("model: ") + key);
        return static_cast<int>(value->GetUint());
    }
    // Lower case: enumerators are compared without case [3].
    static std::string GetWord(const Value& object, const char* key) {
        const Value* value = Find(object, key);
        std::string word = value == nullptr ? "" : value->GetString();
        std::transform(word.begin(), word.end(), word.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        return word;
    }
    // An object in place of an array is an array of one [3].
    template <typename Function>
    static void ForEach(const Value& object, const char* key, Function function) {
        const Value* value = Find(object, key);
        if (value == nullptr)
            return;
        if (value->IsObject())
            return function(*value);
        for (const Value& element : value->GetArray())
            function(element);
    }

    View GetView(std::size_t index) const {
        if (index >= views_.size())
            throw std::runtime_error("model: view");
        return views_[index];
    }
    template <typename T>
    std::vector<T> LoadVector(std::size_t view, std::size_t count) const {
        std::vector<T> values(count);
        const View place = GetView(view);
        // A mistake may point behind the file; a decoder reads something there.
        const std::size_t end = std::min(place.offset, file_.size());
        std::memcpy(values.data(), file_.data() + end, std::min(count * sizeof(T), file_.size() - end));
        return values;
    }

    void ReadNetworks(ModelSet& set) { // [6.1]
        std::vector<const Value*> networks;
        if (const Value* mlp = Find(root_, "mlp"))
            networks.push_back(mlp);
        ForEach(root_, "mlpVersions", [&](const Value& mlp) { networks.push_back(&mlp); });
        for (const Value* network : networks) {
            std::vector<const Value*> layers;
            ForEach(*network, "layers", [&](const Value& layer) { layers.push_back(&layer); });
            if (layers.size() != 4)
                throw std::runtime_error("model: layers");
            const std::string ownType = GetWord(*layers[0], "weightType");
            const std::string type = ownType.empty() ? GetWord(*network, "weightType") : ownType;
            const bool isFP8 = type == "floate4m3";
            set.highSlots = (GetInt(*layers[0], "inputChannels") - 32) / 4;
            ModelNetwork read;
            for (std::size_t i = 0; i < 4; ++i)
                read[i] = ReadLayer(*network, *layers[i], i, isFP8);
            (isFP8 ? set.fp8 : set.int8) = std::move(read);
        }
        if (Makes(Mistake::FirstNetworkIsInt8) && set.fp8 && networks.size() > 1)
            set.int8 = ReadAsInt8(*networks.front());
    }

    ModelNetwork ReadAsInt8(const Value& network) const {
        ModelNetwork read;
        std::size_t i = 0;
        ForEach(network, "layers", [&](const Value& layer) {
            const auto rows = Index(GetInt(layer, "outputChannels"));
            read[i].weights = LoadVector<std::uint8_t>(Index(GetInt(layer, "weightView")),
                                                       rows * Index(GetInt(layer, "inputChannels")));
            read[i].scales.assign(rows, 0x1p-16f);
            read[i].biases.assign(rows, 0);
            ++i;
        });
        return read;
    }

    ModelLayer ReadLayer(const Value& network, const Value& layer, std::size_t index, bool isFP8) const {
        const auto rows = Index(GetInt(layer, "outputChannels"));
        const auto columns = Index(GetInt(layer, "inputChannels"));
        std::size_t weightView = Index(GetInt(layer, "weightView"));
        std::size_t biasView = Index(GetInt(layer, "biasView"));
        const Value* scaleMember = Find(layer, "scaleView");
        std::size_t scaleView = scaleMember == nullptr ? 0 : scaleMember->GetUint();
        if (Makes(Mistake::FixedViews) && !isFP8) {
            weightView = 3 * index;
            scaleView = 3 * index + 1;
            biasView = 3 * index + 2;
        }
        ModelLayer read;
        read.weights = LoadVector<std::uint8_t>(weightView, rows * columns);
        if (isFP8 && index < 3) {
            read.halfBiases = LoadVector<std::uint16_t>(biasView, rows);
            return read;
        }
        if (scaleMember != nullptr)
            read.scales = LoadVector<float>(scaleView, rows);
        else
            read.scales.assign(rows, Makes(Mistake::AbsentScalesZero) ? 0.0f : 1.0f);
        if (IsLegacyBias(network, layer))
            FoldBiases(read, LoadVector<float>(biasView, rows), columns);
        else
            read.biases = LoadVector<std::int32_t>(biasView, rows);
        return read;
    }

    bool IsLegacyBias(const Value& network, const Value& layer) const { // [6]
        std::string type = GetWord(layer, "biasType");
        if (!type.empty() && Makes(Mistake::LegacyBiasBits))
            return false;
        if (type.empty() && !Makes(Mistake::LegacyTypeOfLayer))
            type = GetWord(layer, "scaleBiasType");
        if (type.empty() && !Makes(Mistake::LegacyTypeOfNetwork))
            type = GetWord(network, "scaleBiasType");
        return type == "float32";
    }

    void FoldBiases(ModelLayer& layer, const std::vector<float>& biases, std::size_t columns) const { // [6.2]
        for (std::size_t row = 0; row < biases.size(); ++row) {
            const double bias = static_cast<double>(biases[row]);
            const double scale = static_cast<double>(layer.scales[row]);
            double quotient = RoundToBinary32(bias / scale);
            if (scale == 0 && !Makes(Mistake::LegacyZeroScale)) {
                quotient = RoundToBinary32(bias * 65536);
                layer.scales[row] = 0x1p-16f;
                std::fill_n(layer.weights.begin() + static_cast<std::ptrdiff_t>(row * columns), columns,
                            std::uint8_t{0});
            }
            const double rounded = Makes(Mistake::LegacyTruncatedBias) ? std::trunc(quotient)
                                   : Makes(Mistake::LegacyTiesToEven)  ? std::nearbyint(quotient)
                                                                       : std::round(quotient);
            layer.biases.push_back(ToSaturatedInt(rounded));
        }
    }

    void ReadChannels(ModelSet& set) const { // [4.6]
        std::size_t channel = 0;
        ForEach(root_, "channels", [&](const Value& record) {
            const std::string space = GetWord(record, "colorSpace");
            set.colorSpaces[channel] = space == "srgb" ? 1 : space == "hlg" ? 2 : 0;
            const Value* scale = Find(record, "scale");
            const Value* bias = Find(record, "bias");
            set.legacyScales[channel] = scale == nullptr ? 1 : scale->GetFloat();
            set.legacyBiases[channel] = bias == nullptr ? 0 : bias->GetFloat();
            ++channel;
        });
        std::fill(set.legacyScales.begin() + static_cast<std::ptrdiff_t>(channel), set.legacyScales.end(),
                  1.0f);
    }

    void ReadImages(ModelSet& set) const { // [4.7]
        const Value& shape = root_["latentShape"];
        const std::size_t count = root_["latents"].IsObject() ? 1 : root_["latents"].Size();
        ForEach(root_, "latents", [&](const Value& record) {
            const auto make = [&](const char* width, const char* height, const char* features,
                                  const char* bits, const char* view, std::size_t fixedView) {
                ModelGrid grid;
                grid.width = GetInt(record, width);
                grid.height = GetInt(record, height);
                grid.features = grid.stride = GetInt(shape, features);
                grid.bits = GetInt(shape, bits);
                grid.rowBits = Index(grid.width) * Index(grid.features) * Index(grid.bits);
                const View place =
                    GetView(Makes(Mistake::FixedViews) ? fixedView : Index(GetInt(record, view)));
                grid.offset = place.offset;
                grid.size = place.size;
                return grid;
            };
            const std::size_t fixed = views_.size() - 2 * (count - set.images.size());
            set.images.push_back({make("highResWidth", "highResHeight", "highResFeatures", "highResQuantBits",
                                       "highResView", fixed),
                                  make("lowResWidth", "lowResHeight", "lowResFeatures", "lowResQuantBits",
                                       "lowResView", fixed + 1)});
        });
    }

    void ReadLatentMips(ModelSet& set) const { // generations [2], [4]
        const auto layers = Index(GetInt(root_["latentShape"], "numFeatures")) / 4;
        ForEach(root_, "latents", [&](const Value& record) {
            ModelLatentMip mip;
            mip.width = GetInt(record, "width");
            mip.height = GetInt(record, "height");
            for (std::size_t layer = 0; layer < layers; ++layer) {
                const bool isArray = set.generation == 2;
                const std::size_t view =
                    isArray ? Index(GetInt(record, "view"))
                            : record["layerViews"][static_cast<rapidjson::SizeType>(layer)].GetUint();
                const std::size_t before = isArray ? 2 * layer * Index(mip.width) * Index(mip.height) : 0;
                mip.layers.push_back(GetView(view).offset + before);
            }
            set.latentMips.push_back(std::move(mip));
        });
    }

    void ReadMips(ModelSet& set) const { // [4.8]
        int mip = 0;
        ForEach(root_, "colorMips", [&](const Value& record) {
            ModelMip read;
            read.width = std::max(set.width >> mip, 1);
            read.height = std::max(set.height >> mip, 1);
            read.image = GetInt(record, "latentMip");
            const Value* lod = Find(record, "positionLod");
            const Value* scale = Find(record, "positionScale");
            if (lod != nullptr && scale != nullptr) {
                read.lod = static_cast<float>(lod->GetDouble());
                read.scale = static_cast<float>(scale->GetDouble());
            } else if (Makes(Mistake::AbsentPositionsZero)) {
                read.scale = 1;
            } else {
                const int distance = mip - 2 * read.image;
                read.lod = static_cast<float>(distance / 3.0);
                read.scale = static_cast<float>(std::ldexp(1.0, distance));
            }
            set.mips.push_back(read);
            ++mip;
        });
    }

    std::span<const std::byte> file_;
    Mistake mistake_;
    rapidjson::Document root_;
    std::vector<View> views_;
};

} // namespace

ModelSet ReadModelSet(std::span<const std::byte> file, Mistake mistake) {
    return FileReaderOfModel(file, mistake).Read();
}

} // namespace openntc::conformance
