// SPDX-License-Identifier: MIT
// The encodings that cases decode, from a folder that is filled when something is missing.
#pragma once

#include "Decoder.h"
#include "report/Cases.h"
#include "report/Report.h"

#include "openntc/encode/Material.h"

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace openntc::report {

struct CacheSettings {
    std::filesystem::path folder;
    std::string model; ///< folder or .gltf file of a model, or empty
    std::uint64_t steps = 6000;
};

/// A material's texels.
struct Source {
    encode::Material material;
    std::array<float, 16> lossScales{};
    int maskChannel = -1;
    std::uint32_t crc32 = 0; ///< of the texels
};

struct Encoding {
    EncodingRecord record;
    std::string path; ///< of the file
    std::shared_ptr<const Source> source;
    tool::DecodeData int8, fp8;

    const tool::DecodeData& GetData(int math) const;
    /// Outputs 0 ... 15 as bits: the first `count` that a texture covers, then others.
    std::uint32_t GetOutputMask(int count) const;
};

/// What is known of a case before it is measured, but the device.
CaseRecord DescribeCase(const Case& c, const Encoding& encoding);

/// Loads, and trains what is missing: the known latent shape for the bits per pixel, with an FP8 network,
/// seed 1 and a fixed number of steps, so that an encoder with the same kernel makes the same bytes again.
/// Generation 2, which no encoder makes: what MakeGeneration2 makes of generation 3.
class EncodingCache {
public:
    /// `say` is called with a line and the fraction done while training.
    EncodingCache(CacheSettings settings, std::function<void(const std::string&, double)> say);

    /// Name of the model's material that is used, or empty without a model.
    const std::string& GetModelMaterial() const { return modelMaterial_; }
    /// Throws CommandError.
    const Encoding& Get(const Case& c);
    /// Texels alone.
    std::shared_ptr<const Source> GetSource(const std::string& material);
    /// In the order of first use.
    std::vector<EncodingRecord> ListRecords() const;

    double GetFillSeconds() const { return fillSeconds_; }
    int GetFilled() const { return filled_; }
    const std::string& GetKernel() const { return kernel_; }

private:
    void Train(const Case& c, const Source& source, const std::filesystem::path& path);
    /// The file of an encoding, made if it was not there.
    std::filesystem::path Fill(const Case& c, const Source& source);

    CacheSettings settings_;
    std::function<void(const std::string&, double)> say_;
    std::string modelMaterial_;
    std::filesystem::path modelFile_;
    std::map<std::string, std::shared_ptr<const Source>> sources_;
    std::map<std::string, std::unique_ptr<Encoding>> encodings_;
    std::vector<std::string> order_;
    double fillSeconds_ = 0;
    int filled_ = 0;
    std::string kernel_;
};

/// $XDG_CACHE_HOME/openntc/report, else ~/.cache/openntc/report, else a folder beside the output.
std::filesystem::path GetDefaultCache(const std::string& output);

} // namespace openntc::report
