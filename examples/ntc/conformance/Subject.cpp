// SPDX-License-Identifier: MIT
#include "Subject.h"

#include "../Failure.h"

#include <optional>

namespace openntc::conformance {

namespace {

class BackendSubject final : public Subject {
public:
    explicit BackendSubject(const tool::BackendOptions& backend) : backend_(backend) {}

    std::string GetName() const override { return name_; }
    Capabilities GetCapabilities() override { return {{true, true, true, true, true}, true, true}; }
    Arithmetic GetArithmetic() const override {
        return backend_.backend == tool::Backend::Vulkan ? Arithmetic::Vulkan : Arithmetic::Host;
    }
    bool UsesOurLoader() const override { return true; }

    void Open(const std::string& path) override {
        data_.reset();
        set_.emplace(tool::LoadTextureSet(path));
        path_ = path;
    }

    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                      const DecodeOptions& options) override {
        return tool::DecodeTexels(GetDecoder(options.math), set_->metadata, texels, options, path_);
    }

    std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options) override {
        std::vector<Outputs> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        tool::Require(GetDecoder(options.math)
                          .Decode(mip, {0, 0, width, height}, options,
                                  std::span(values.data()->data(), values.size() * 16)),
                      tool::ExitCode::Failed, path_);
        return values;
    }

private:
    // On the CPU a decoder is for the modes of one kind only: those with and without a fast form. Where a decoder can take
    // another set, the one that is there is used.
    tool::Decoder& GetDecoder(DecodeMath math) {
        const std::size_t kind = math == DecodeMath::FP8                                    ? 0
                                 : math == DecodeMath::Int8 || math == DecodeMath::Int8Half ? 1
                                                                                            : 2;
        if (decoder_ != nullptr && data_ != nullptr && kind_ == kind)
            return *decoder_;
        auto data = std::make_unique<tool::DecodeData>(tool::LoadDecodeData(*set_, math));
        const bool isRebound =
            decoder_ != nullptr && tool::Require(decoder_->Rebind(*data), tool::ExitCode::BadInput, path_);
        if (!isRebound)
            decoder_ = MakeDecoder(*data, kind);
        data_ = std::move(data);
        kind_ = kind;
        return *decoder_;
    }

    std::unique_ptr<tool::Decoder> MakeDecoder(const tool::DecodeData& data, std::size_t kind) {
        Expected<std::unique_ptr<tool::Decoder>> decoder = tool::MakeDecoder(data, backend_);
        // The fast decoder has no form of the other modes for a named instruction set.
        if (!decoder && kind != 1 && backend_.backend == tool::Backend::Cpu)
            throw SubjectError(SubjectError::Kind::NotSupported, decoder.error().GetText());
        const bool absent = !decoder && decoder.error().GetStatus() == Status::Unsupported;
        auto made = tool::Require(std::move(decoder),
                                  absent ? tool::ExitCode::NoDevice : tool::ExitCode::BadInput, path_);
        name_ = made->GetDeviceName();
        return made;
    }

    tool::BackendOptions backend_;
    std::string path_;
    std::string name_;
    std::optional<tool::TextureSet> set_;
    std::size_t kind_ = 0;
    std::unique_ptr<tool::DecodeData> data_; // of the open set, once something was decoded
    std::unique_ptr<tool::Decoder> decoder_;
};

class ModelSubject final : public Subject {
public:
    explicit ModelSubject(Mistake mistake) : mistake_(mistake) {}

    std::string GetName() const override {
        for (const MistakeInfo& info : ListMistakes()) {
            if (info.mistake == mistake_)
                return std::string("wrong decoder: ") + info.name;
        }
        return "independent model";
    }
    Capabilities GetCapabilities() override { return {{true, true, true, true, true}, true, false}; }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }

    void Open(const std::string& path) override {
        set_.emplace(tool::LoadTextureSet(path));
        file_ = tool::ReadAll(path);
    }

    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                      const DecodeOptions& options) override {
        const Model model(set_->metadata, file_);
        std::vector<Outputs> values;
        for (const tool::Texel& texel : texels)
            values.push_back(
                model.Decode(options.math, options.convertToLinear, texel.mip, texel.x, texel.y, mistake_));
        return values;
    }

private:
    Mistake mistake_;
    std::optional<tool::TextureSet> set_;
    std::vector<std::byte> file_;
};

} // namespace

std::vector<Outputs> Subject::DecodeMip(int mip, int width, int height, const DecodeOptions& options) {
    std::vector<tool::Texel> texels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x)
            texels.push_back({mip, x, y});
    }
    return DecodeTexels(texels, options);
}

std::unique_ptr<Subject> MakeBackendSubject(const tool::BackendOptions& backend) {
    return std::make_unique<BackendSubject>(backend);
}

std::unique_ptr<Subject> MakeModelSubject(Mistake mistake) {
    return std::make_unique<ModelSubject>(mistake);
}

} // namespace openntc::conformance
