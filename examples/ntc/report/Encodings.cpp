// SPDX-License-Identifier: MIT
#include "report/Encodings.h"

#include "Failure.h"
#include "FileNames.h"
#include "Interrupt.h"
#include "Output.h"
#include "encode/EncodeInputs.h"
#include "encode/StateFile.h"
#include "encode/Training.h"
#include "gltf/GltfMaterials.h"
#include "materials/Materials.h"
#include "report/Generations.h"

#include "openntc/MathModes.h"
#include "openntc/core/Crc32.h"
#include "openntc/format/NetworkDescription.h"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;

namespace {

constexpr int kBricksSize = 256;
constexpr std::uint32_t kSeed = 1;

fs::path FindModelFile(const std::string& model) {
    std::error_code ignored;
    if (!fs::is_directory(model, ignored))
        return model;
    for (const fs::directory_entry& entry : fs::directory_iterator(model, ignored)) {
        if (entry.path().extension() == ".gltf")
            return entry.path();
    }
    throw CommandError(ExitCode::BadInput, model, "model: no .gltf file in this folder");
}

/// Squared error of all mips by texels, in dB (docs/encoder.md).
double MeasurePsnr(const tool::DecodeData& data, const encode::Material& material, const std::string& name) {
    const std::unique_ptr<tool::Decoder> decoder = tool::RequireDecoder(name, data, {});
    double squares = 0, values = 0;
    std::vector<float> texels;
    for (int m = 0; m < material.GetMipCount(); ++m) {
        const int width = material.GetWidth(m), height = material.GetHeight(m);
        texels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 16);
        tool::Require(decoder->Decode(m, {0, 0, width, height}, {}, texels), ExitCode::BadInput, name);
        for (std::size_t c = 0; c < 16; ++c) {
            const std::span<const float> plane = material.GetPlane(m, static_cast<int>(c));
            for (std::size_t i = 0; i < plane.size(); ++i) {
                const double error = static_cast<double>(texels[16 * i + c]) - static_cast<double>(plane[i]);
                squares += error * error;
            }
            values += static_cast<double>(plane.size());
        }
    }
    return -10.0 * std::log10(squares / values);
}

} // namespace

const tool::DecodeData& Encoding::GetData(int math) const {
    return math == NTC_MATH_FP8 || math == NTC_MATH_COOPVEC_FP8 ? fp8 : int8;
}

std::uint32_t Encoding::GetOutputMask(int count) const {
    const std::uint32_t declared = source->material.GetDeclaredChannels();
    std::uint32_t mask = 0;
    for (const std::uint32_t candidates : {declared, ~declared & 0xFFFFu}) {
        for (int c = 0; c < 16; ++c) {
            if (std::popcount(mask) < count)
                mask |= candidates & (1u << c);
        }
    }
    return mask;
}

CaseRecord DescribeCase(const Case& c, const Encoding& encoding) {
    CaseRecord record;
    record.id = c.GetId();
    record.axes = c.axes;
    record.encoding = encoding.record.name;
    record.material = c.material;
    record.math = GetMathName(c.math);
    record.network = GetNetworkName(c.network);
    record.weights = GetWeightsName(c.weights);
    record.bitsPerPixel = c.bitsPerPixel;
    record.outputs = c.outputs;
    record.linear = c.linear;
    record.sets = c.sets;
    record.instructions = GetInstructionsName(c.instructions);
    record.latents = c.latentTexture ? "texture" : "";
    record.fileBytes = encoding.record.fileBytes;
    record.memoryBytes =
        encoding.record.memoryBytes - encoding.int8.weights.size() + encoding.GetData(c.math).weights.size();
    return record;
}

EncodingCache::EncodingCache(CacheSettings settings, std::function<void(const std::string&, double)> say)
    : settings_(std::move(settings)), say_(std::move(say)) {
    if (settings_.model.empty())
        return;
    modelFile_ = FindModelFile(settings_.model);
    const std::vector<tool::GltfMaterial> materials = tool::ReadGltfMaterials(modelFile_.string());
    for (const tool::GltfMaterial& material : materials) {
        if (!material.errors.empty())
            throw CommandError(ExitCode::BadInput, modelFile_.string(), material.errors.front());
        const bool isFirst = modelMaterial_.empty() && !material.textures.empty();
        if (isFirst ||
            material.name.find("Leather") != std::string::npos) // the one that LibNTC's figures are of
            modelMaterial_ = material.name;
    }
    if (modelMaterial_.empty())
        throw CommandError(ExitCode::BadInput, modelFile_.string(), "materials: none has images");
}

std::shared_ptr<const Source> EncodingCache::GetSource(const std::string& material) {
    std::shared_ptr<const Source>& kept = sources_[material];
    if (kept)
        return kept;
    tool::InputOptions options;
    if (material == kBricks) {
        const fs::path folder = settings_.folder / "sources";
        std::error_code error;
        fs::create_directories(folder, error);
        if (error)
            throw CommandError(ExitCode::Failed, folder.string(),
                               "cache: cannot be made: " + error.message());
        if (!materials::WriteBricks(folder, kBricksSize))
            throw CommandError(ExitCode::Failed, folder.string(), "cache: cannot be written");
        options.paths = {(folder / "bricks.json").string()};
    } else {
        for (const tool::GltfMaterial& m : tool::ReadGltfMaterials(modelFile_.string())) {
            if (m.name == material)
                options.manifest = tool::MakeManifest(m);
        }
        options.paths = {modelFile_.string()};
    }
    tool::EncodeInputs inputs = tool::LoadInputs(options);
    std::uint32_t crc = 0;
    for (int c = 0; c < 16; ++c)
        crc = Crc32(std::as_bytes(inputs.material.GetPlane(0, c)), crc);
    kept = std::make_shared<Source>(
        Source{std::move(inputs.material), inputs.lossScales, inputs.maskChannel, crc});
    return kept;
}

void EncodingCache::Train(const Case& c, const Source& source, const fs::path& path) {
    const auto start = std::chrono::steady_clock::now();
    encode::EncodeOptions options;
    options.bitsPerPixel = static_cast<float>(c.bitsPerPixel);
    options.networkVersion = c.network;
    options.steps = settings_.steps;
    options.seed = kSeed;
    options.fp8 = true;
    options.lossScales = source.lossScales;
    options.maskChannel = source.maskChannel;
    Expected<encode::EncodeResult> trained =
        tool::Train(source.material, options, [&](const encode::Progress& progress) {
            say_("training " + GetEncodingName(c), progress.fraction);
            return !tool::IsInterrupted();
        });
    const encode::EncodeResult result =
        tool::Require(std::move(trained), ExitCode::Failed, GetEncodingName(c));
    tool::ThrowIfInterrupted();
    tool::WriteWholeFile(path.string(), {result.file});
    kernel_ = result.kernel;
    fillSeconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    ++filled_;
}

fs::path EncodingCache::Fill(const Case& c, const Source& source) {
    tool::FileNames names;
    fs::path path =
        settings_.folder / (names.Add(GetEncodingName(c)) +
                            tool::Format("-%llu-steps-%08x.ntc",
                                         static_cast<unsigned long long>(settings_.steps), source.crc32));
    std::error_code error;
    if (fs::exists(path, error))
        return path;
    if (c.network == NTC_NETWORK_GENERATION_2) {
        Case third = c;
        third.network = NTC_NETWORK_GENERATION_3;
        tool::TextureSet set = tool::LoadTextureSet(Fill(third, source).string());
        tool::WriteWholeFile(path.string(), {MakeGeneration2(set)});
    } else {
        Train(c, source, path);
    }
    return path;
}

const Encoding& EncodingCache::Get(const Case& c) {
    const std::string name = GetEncodingName(c);
    std::unique_ptr<Encoding>& kept = encodings_[name];
    if (kept)
        return *kept;
    const std::shared_ptr<const Source> source = GetSource(c.material);
    const fs::path path = Fill(c, *source);
    tool::TextureSet set = tool::LoadTextureSet(path.string());
    auto encoding = std::make_unique<Encoding>();
    encoding->source = source;
    encoding->path = path.string();
    encoding->int8 = tool::LoadDecodeData(set, DecodeMath::Int8);
    encoding->fp8 = tool::LoadDecodeData(set, DecodeMath::FP8);
    const TextureSetDesc& desc = set.metadata.GetDesc();
    if (desc.width != source->material.GetWidth() || desc.height != source->material.GetHeight() ||
        desc.mips != source->material.GetMipCount() || set.metadata.GetNetworkVersion() != c.network)
        throw CommandError(ExitCode::BadInput, path.string(),
                           "cache: not an encoding of " + name + ": remove it");
    EncodingRecord& record = encoding->record;
    const LatentShape& shape = set.metadata.GetLatentShape();
    record.name = name;
    record.material = c.material;
    record.network = GetNetworkName(c.network);
    record.bitsPerPixel = c.bitsPerPixel;
    record.latentShape = {shape.gridSizeScale, shape.highResFeatures, shape.lowResFeatures,
                          shape.highResQuantBits, shape.lowResQuantBits};
    record.width = desc.width;
    record.height = desc.height;
    record.mips = desc.mips;
    record.channels = std::popcount(source->material.GetDeclaredChannels());
    record.steps = settings_.steps;
    record.seed = kSeed;
    std::error_code error;
    record.fileBytes = static_cast<std::uint64_t>(fs::file_size(path, error));
    record.memoryBytes =
        encoding->int8.latents.size() + encoding->int8.weights.size() + sizeof(NtcTextureSetConstants);
    record.trueBitsPerPixel = 8.0 * static_cast<double>(encoding->int8.latents.size()) /
                              (static_cast<double>(desc.width) * desc.height);
    record.psnr = MeasurePsnr(encoding->int8, source->material, name);
    kept = std::move(encoding);
    order_.push_back(name);
    return *kept;
}

std::vector<EncodingRecord> EncodingCache::ListRecords() const {
    std::vector<EncodingRecord> records;
    for (const std::string& name : order_)
        records.push_back(encodings_.at(name)->record);
    return records;
}

fs::path GetDefaultCache(const std::string& output) {
    const char* cache = std::getenv("XDG_CACHE_HOME");
    if (cache != nullptr && *cache != '\0')
        return fs::path(cache) / "openntc" / "report";
    const char* home = std::getenv("HOME");
    if (home != nullptr && *home != '\0')
        return fs::path(home) / ".cache" / "openntc" / "report";
    return fs::path(output + ".cache");
}

} // namespace openntc::report
