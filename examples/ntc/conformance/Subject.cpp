// SPDX-License-Identifier: MIT
#include "Subject.h"

#include "../Failure.h"

#include <algorithm>
#include <list>
#include <optional>

namespace openntc::conformance {

namespace {

std::vector<tool::Texel> ListTexels(const SliceRequest& slice) {
    std::vector<tool::Texel> texels;
    int mip = slice.firstMip;
    for (const Rect& part : slice.parts) {
        for (int y = part.top; y < part.top + part.height; ++y) {
            for (int x = part.left; x < part.left + part.width; ++x)
                texels.push_back({mip, x, y});
        }
        ++mip;
    }
    return texels;
}

class BackendSubject final : public Subject {
public:
    explicit BackendSubject(const tool::BackendOptions& backend) : backend_(backend) {}

    std::string GetName() const override { return name_; }
    Capabilities GetCapabilities() override {
        // The fast decoder has no form of the other modes for a named instruction set.
        const bool isNamed = backend_.backend == tool::Backend::Cpu && backend_.simd != SimdTarget{};
        const bool isHost = backend_.backend != tool::Backend::Vulkan; // what is C++ here
        return {{false, true, true, !isNamed, !isNamed, !isNamed},
                true,
                true,
                true,
                true,
                true,
                isHost,
                isHost,
                isHost};
    }
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
        tool::Decoder& decoder = GetDecoder(options.math);
        const auto isInside = [&](const tool::Texel& texel) {
            const ColorMip& mip = set_->metadata.GetColorMips()[static_cast<std::size_t>(texel.mip)];
            return texel.x >= 0 && texel.y >= 0 && texel.x < mip.width && texel.y < mip.height;
        };
        if (std::all_of(texels.begin(), texels.end(), isInside))
            return tool::DecodeTexels(decoder, set_->metadata, texels, options, path_);
        std::vector<Outputs> values(texels.size());
        for (std::size_t i = 0; i < texels.size(); ++i)
            Decode(decoder, texels[i].mip, {texels[i].x, texels[i].y, 1, 1}, options, values[i]);
        return values;
    }

    std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options) override {
        return DecodeRect(GetDecoder(options.math), mip, {0, 0, width, height}, options);
    }

    /// From the latents of the slice alone.
    std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
        const int mips = static_cast<int>(slice.parts.size());
        tool::Decoder& decoder =
            Use(tool::LoadSliceData(*set_, options.math, {slice.firstMip, mips, slice.rect}));
        std::vector<Outputs> values;
        int mip = slice.firstMip;
        for (const Rect& part : slice.parts) {
            if (part.width > 0 && part.height > 0) {
                const std::vector<Outputs> some = DecodeRect(decoder, mip, part, options);
                values.insert(values.end(), some.begin(), some.end());
            }
            ++mip;
        }
        data_.reset(); // what comes next is of the whole set
        return values;
    }

    std::vector<std::byte> EncodeBlocks(const BlockRequest& request) override {
        return EncodeBlockRequest(request);
    }

    Textures MakeTextures(const TextureRequest& request) override {
        return conformance::MakeTextures(
            set_->metadata, request,
            DecodeRect(GetDecoder(request.math), request.mip, request.rect, {request.math, false}));
    }

    FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups) override {
        return RunFilter(request, lookups);
    }

    bool Restart() override {
        decoder_.reset();
        data_.reset();
        set_.reset();
        return true;
    }

private:
    void Decode(tool::Decoder& decoder, int mip, const Rect& rect, const DecodeOptions& options,
                std::span<float> values) const {
        tool::Require(decoder.Decode(mip, rect, options, values), tool::ExitCode::Failed, path_);
    }

    std::vector<Outputs> DecodeRect(tool::Decoder& decoder, int mip, const Rect& rect,
                                    const DecodeOptions& options) const {
        std::vector<Outputs> values(static_cast<std::size_t>(rect.width) *
                                    static_cast<std::size_t>(rect.height));
        Decode(decoder, mip, rect, options, std::span(values.data()->data(), values.size() * 16));
        return values;
    }

    static std::size_t GetKind(DecodeMath math) {
        return math == DecodeMath::FP8 ? 0 : math == DecodeMath::Int8 || math == DecodeMath::Int8Half ? 1 : 2;
    }

    // On the CPU a decoder is for the modes of one kind only: those with and without a fast form. Where a decoder can take
    // another set, the one that is there is used.
    tool::Decoder& GetDecoder(DecodeMath math) {
        const std::size_t kind = GetKind(math);
        if (decoder_ != nullptr && data_ != nullptr && kind_ == kind)
            return *decoder_;
        return Use(tool::LoadDecodeData(*set_, math));
    }

    tool::Decoder& Use(tool::DecodeData&& decodeData) {
        const std::size_t kind = GetKind(decodeData.math);
        auto data = std::make_unique<tool::DecodeData>(std::move(decodeData));
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
    explicit ModelSubject(BlockMistake mistake) : blockMistake_(mistake) {}
    explicit ModelSubject(TextureMistake mistake) : textureMistake_(mistake) {}
    explicit ModelSubject(FilterMistake mistake) : filterMistake_(mistake) {}

    std::string GetName() const override {
        std::string name = "independent model";
        const auto find = [&name](auto infos, auto mistake, const char* kind) {
            for (const auto& info : infos) {
                if (info.mistake == mistake)
                    name = std::string(kind) + info.name;
            }
        };
        find(ListMistakes(), mistake_, "wrong decoder: ");
        find(ListBlockMistakes(), blockMistake_, "wrong encoder: ");
        find(ListTextureMistakes(), textureMistake_, "wrong textures: ");
        find(ListFilterMistakes(), filterMistake_, "wrong filter: ");
        return name;
    }
    Capabilities GetCapabilities() override {
        return {{false, true, true, true, true, true}, true, true, true, true, true, true, true, true};
    }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }

    void Open(const std::string& path) override {
        tool::LoadTextureSet(path); // says what is wrong with a file that the model cannot read
        files_.push_back(tool::ReadAll(path));
        Model model(files_.back());
        if (model_)
            model.KeepFrom(*model_, mistake_);
        model_.emplace(std::move(model));
    }

    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                      const DecodeOptions& options) override {
        std::vector<Outputs> values;
        for (const tool::Texel& texel : texels)
            values.push_back(model_->Decode(
                {options.math, options.convertToLinear, texel.mip, texel.x, texel.y}, mistake_));
        return values;
    }
    std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options) override {
        return DecodeAll(RequestKind::WholeMip, {mip, {}, {{0, 0, width, height}}}, options);
    }
    std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
        return DecodeAll(RequestKind::Slice, slice, options);
    }
    std::vector<std::byte> EncodeBlocks(const BlockRequest& request) override {
        return EncodeBlockRequest(request, blockMistake_);
    }
    Textures MakeTextures(const TextureRequest& request) override {
        return TextureModel(*model_, request).Make(textureMistake_);
    }
    FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups) override {
        return RunFilter(request, lookups, filterMistake_);
    }
    bool Restart() override {
        model_.reset();
        return true;
    }

private:
    std::vector<Outputs> DecodeAll(RequestKind kind, const SliceRequest& slice,
                                   const DecodeOptions& options) {
        std::vector<Outputs> values;
        for (const tool::Texel& texel : ListTexels(slice))
            values.push_back(
                model_->Decode({options.math, options.convertToLinear, texel.mip, texel.x, texel.y, kind,
                                slice.rect, slice.firstMip, static_cast<int>(slice.parts.size())},
                               mistake_));
        return values;
    }

private:
    Mistake mistake_ = Mistake::None;
    BlockMistake blockMistake_ = BlockMistake::None;
    TextureMistake textureMistake_ = TextureMistake::None;
    FilterMistake filterMistake_ = FilterMistake::None;
    std::list<std::vector<std::byte>> files_; // all of them: a mistake may keep the latents of any
    std::optional<Model> model_;
};

} // namespace

std::vector<Outputs> Subject::DecodeMip(int mip, int width, int height, const DecodeOptions& options) {
    const Rect all{0, 0, width, height};
    return Subject::DecodeSlice({mip, all, {all}}, options);
}

std::vector<Outputs> Subject::DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) {
    return DecodeTexels(ListTexels(slice), options);
}

std::vector<std::byte> Subject::EncodeBlocks(const BlockRequest&) {
    throw SubjectError(SubjectError::Kind::NotSupported, "not supported: blocks");
}

Textures Subject::MakeTextures(const TextureRequest&) {
    throw SubjectError(SubjectError::Kind::NotSupported, "not supported: textures");
}

FilterTaps Subject::FilterLookups(const FilterRequest&, std::span<const FilterLookup>) {
    throw SubjectError(SubjectError::Kind::NotSupported, "not supported: filtering");
}

std::size_t SliceRequest::CountTexels() const {
    std::size_t count = 0;
    for (const Rect& part : parts)
        count += static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
    return count;
}

std::size_t SliceRequest::GetIndex(const tool::Texel& texel) const {
    SliceRequest before = *this;
    before.parts.resize(static_cast<std::size_t>(texel.mip - firstMip));
    const Rect& part = parts.at(before.parts.size());
    return before.CountTexels() +
           static_cast<std::size_t>(texel.y - part.top) * static_cast<std::size_t>(part.width) +
           static_cast<std::size_t>(texel.x - part.left);
}

std::unique_ptr<Subject> MakeBackendSubject(const tool::BackendOptions& backend) {
    return std::make_unique<BackendSubject>(backend);
}

std::unique_ptr<Subject> MakeModelSubject(Mistake mistake) {
    return std::make_unique<ModelSubject>(mistake);
}

std::unique_ptr<Subject> MakeModelSubject(BlockMistake mistake) {
    return std::make_unique<ModelSubject>(mistake);
}

std::unique_ptr<Subject> MakeModelSubject(TextureMistake mistake) {
    return std::make_unique<ModelSubject>(mistake);
}

std::unique_ptr<Subject> MakeModelSubject(FilterMistake mistake) {
    return std::make_unique<ModelSubject>(mistake);
}

} // namespace openntc::conformance
