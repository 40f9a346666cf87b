// SPDX-License-Identifier: MIT
// A decoder in a shared library with the functions of openntc_adapter.h.
#include "../Failure.h"
#include "Subject.h"

#include "adapter/openntc_adapter.h"

#include <algorithm>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace openntc::conformance {

namespace {

using tool::CommandError;
using tool::ExitCode;

void* LoadLibraryFile(const std::string& path) {
#if defined(_WIN32)
    return reinterpret_cast<void*>(LoadLibraryA(path.c_str()));
#else
    // A name without a slash would be searched for in the system's folders.
    const std::string file = path.find('/') == std::string::npos ? "./" + path : path;
    void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* reason = dlerror();
        throw CommandError(ExitCode::BadInput, path,
                           std::string("library: ") + (reason != nullptr ? reason : ""));
    }
    return library;
#endif
}

void* FindFunction(void* library, const char* name) {
#if defined(_WIN32)
    return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
#else
    return dlsym(library, name);
#endif
}

class LibrarySubject final : public Subject {
public:
    explicit LibrarySubject(const std::string& path) : path_(path), library_(LoadLibraryFile(path)) {
        if (library_ == nullptr)
            throw CommandError(ExitCode::BadInput, path, "library: cannot be loaded");
        Find(version_, "openntc_adapter_version");
        Find(getName_, "openntc_adapter_name");
        Find(getCapabilities_, "openntc_adapter_capabilities");
        Find(error_, "openntc_adapter_error");
        Find(create_, "openntc_adapter_create");
        Find(destroy_, "openntc_adapter_destroy");
        Find(decodeTexels_, "openntc_adapter_decode_texels");
        if (version_() != OPENNTC_ADAPTER_VERSION)
            throw CommandError(ExitCode::BadInput, path, "adapter version: another than this program's");
        if (GetCapabilities().wholeMips)
            Find(decodeMip_, "openntc_adapter_decode_mip");
        if (GetCapabilities().slices)
            Find(decodeSlice_, "openntc_adapter_decode_slice");
        if (GetCapabilities().sliceMips)
            Find(decodeSliceMips_, "openntc_adapter_decode_slice_mips");
        if (GetCapabilities().blocks)
            Find(encodeBlocks_, "openntc_adapter_encode_blocks");
        if (GetCapabilities().textures)
            Find(decodeTextures_, "openntc_adapter_decode_textures");
        if (GetCapabilities().filtering)
            Find(filter_, "openntc_adapter_filter");
    }
    ~LibrarySubject() override { Close(); } // the library stays loaded: it may have threads
    LibrarySubject(const LibrarySubject&) = delete;
    LibrarySubject& operator=(const LibrarySubject&) = delete;

    std::string GetName() const override {
        const char* name = getName_();
        return name != nullptr ? name : "";
    }
    Arithmetic GetArithmetic() const override { return Arithmetic::Vulkan; }

    Capabilities GetCapabilities() override {
        const std::uint32_t bits = getCapabilities_();
        Capabilities capabilities;
        for (std::size_t math = 1; math < capabilities.math.size(); ++math)
            capabilities.math[math] = (bits >> math & 1u) != 0;
        capabilities.linear = (bits & OPENNTC_ADAPTER_CAN_LINEAR) != 0;
        capabilities.wholeMips = (bits & OPENNTC_ADAPTER_CAN_DECODE_MIP) != 0;
        capabilities.slices = (bits & OPENNTC_ADAPTER_CAN_DECODE_SLICE) != 0;
        capabilities.sliceMips = (bits & OPENNTC_ADAPTER_CAN_DECODE_SLICE_MIPS) != 0;
        capabilities.outside = (bits & OPENNTC_ADAPTER_CAN_DECODE_OUTSIDE) != 0;
        capabilities.blocks = (bits & OPENNTC_ADAPTER_CAN_ENCODE_BLOCKS) != 0;
        capabilities.textures = (bits & OPENNTC_ADAPTER_CAN_DECODE_TEXTURES) != 0;
        capabilities.filtering = (bits & OPENNTC_ADAPTER_CAN_FILTER) != 0;
        return capabilities;
    }

    void Open(const std::string& path) override {
        Close();
        file_ = tool::ReadAll(path);
        Check(create_(file_.data(), file_.size(), &set_));
    }

    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                      const DecodeOptions& options) override {
        std::vector<OpenntcAdapterTexel> list;
        for (const tool::Texel& texel : texels)
            list.push_back({texel.mip, texel.x, texel.y});
        std::vector<Outputs> values(texels.size());
        RequireSet();
        Check(decodeTexels_(set_, static_cast<int>(options.math), options.convertToLinear ? 1 : 0,
                            list.data(), static_cast<std::uint32_t>(list.size()), values.data()->data()));
        return values;
    }

    std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options) override {
        if (decodeMip_ == nullptr)
            return Subject::DecodeMip(mip, width, height, options);
        std::vector<Outputs> values(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        RequireSet();
        Check(decodeMip_(set_, static_cast<int>(options.math), options.convertToLinear ? 1 : 0, mip,
                         static_cast<std::uint32_t>(values.size()), values.data()->data()));
        return values;
    }

    std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
        const std::size_t mips = slice.parts.size();
        if (mips == 1 ? decodeSlice_ == nullptr : decodeSliceMips_ == nullptr)
            return Subject::DecodeSlice(slice, options);
        std::vector<Outputs> values(slice.CountTexels());
        RequireSet();
        const int math = static_cast<int>(options.math);
        const int linear = options.convertToLinear ? 1 : 0;
        const Rect& rect = slice.rect;
        if (mips == 1)
            Check(decodeSlice_(set_, math, linear, slice.firstMip, rect.left, rect.top, rect.width,
                               rect.height, values.data()->data()));
        else
            Check(decodeSliceMips_(set_, math, linear, slice.firstMip, static_cast<int>(mips), rect.left,
                                   rect.top, rect.width, rect.height,
                                   static_cast<std::uint32_t>(values.size()), values.data()->data()));
        return values;
    }

    std::vector<std::byte> EncodeBlocks(const BlockRequest& request) override {
        if (encodeBlocks_ == nullptr)
            return Subject::EncodeBlocks(request);
        std::vector<std::byte> blocks(request.GetBlockBytes());
        Check(encodeBlocks_(static_cast<int>(request.format), static_cast<int>(request.level),
                            request.alphaThreshold, request.texels.data(),
                            static_cast<uint32_t>(request.width), static_cast<uint32_t>(request.height),
                            blocks.data()));
        return blocks;
    }

    Textures MakeTextures(const TextureRequest& request) override {
        if (decodeTextures_ == nullptr)
            return Subject::MakeTextures(request);
        const OpenntcAdapterRect rect{
            request.mip,          request.rect.left,       request.rect.top,       request.rect.width,
            request.rect.height,  request.destinationLeft, request.destinationTop, request.textureWidth,
            request.textureHeight};
        std::vector<OpenntcAdapterOutput> outputs;
        Textures textures;
        std::vector<void*> texels;
        for (const TextureOutput& output : request.outputs) {
            outputs.push_back({output.firstChannel, output.channels, static_cast<int>(output.rgb),
                               static_cast<int>(output.alpha), output.bits});
            texels.push_back(textures.emplace_back(request.GetTextureBytes(output)).data());
        }
        RequireSet();
        Check(decodeTextures_(set_, static_cast<int>(request.math), &rect, outputs.data(),
                              static_cast<uint32_t>(outputs.size()), texels.data()));
        return textures;
    }

    FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups) override {
        if (filter_ == nullptr)
            return Subject::FilterLookups(request, lookups);
        const OpenntcAdapterSampler sampler{request.kernel,        request.mips,    request.wrapX,
                                            request.wrapY,         request.sigma,   request.radius,
                                            request.maxAnisotropy, request.lodBias, request.width,
                                            request.height,        request.levels};
        FilterTaps all;
        std::vector<OpenntcAdapterTap> taps(OPENNTC_ADAPTER_MOST_TAPS);
        for (const FilterLookup& lookup : lookups) {
            OpenntcAdapterLookup question{};
            for (std::size_t i = 0; i < 2; ++i) {
                question.uv[i] = lookup.uv[i];
                question.ddx[i] = lookup.ddx[i];
                question.ddy[i] = lookup.ddy[i];
            }
            std::copy(lookup.random.begin(), lookup.random.end(), question.random);
            std::uint32_t count = 0;
            Check(filter_(&sampler, static_cast<int>(request.way), &question, taps.data(), &count));
            if (count > taps.size())
                throw SubjectError(SubjectError::Kind::Broken, "more taps than there may be");
            std::vector<FilterTap>& made = all.emplace_back();
            for (const OpenntcAdapterTap& tap : std::span(taps).first(count)) {
                const bool isBorder = tap.isBorder != 0;
                made.push_back({isBorder ? -1 : tap.x, isBorder ? -1 : tap.y, tap.mip, tap.scale, isBorder});
            }
        }
        return all;
    }

private:
    template <typename Function>
    void Find(Function*& function, const char* name) {
        function = reinterpret_cast<Function*>(FindFunction(library_, name));
        if (function == nullptr)
            throw CommandError(ExitCode::BadInput, path_, std::string(name) + ": not exported");
    }

    void Check(int result) {
        if (result == OPENNTC_ADAPTER_OK)
            return;
        const char* text = error_();
        throw SubjectError(result == OPENNTC_ADAPTER_NOT_SUPPORTED ? SubjectError::Kind::NotSupported
                                                                   : SubjectError::Kind::Failed,
                           text != nullptr && *text != '\0' ? text : "no reason given");
    }

    void RequireSet() const {
        if (set_ == nullptr)
            throw SubjectError(SubjectError::Kind::Failed, "no texture set is open");
    }

    void Close() {
        if (set_ != nullptr)
            destroy_(set_);
        set_ = nullptr;
    }

    std::string path_;
    void* library_;
    decltype(openntc_adapter_version)* version_ = nullptr;
    decltype(openntc_adapter_name)* getName_ = nullptr;
    decltype(openntc_adapter_capabilities)* getCapabilities_ = nullptr;
    decltype(openntc_adapter_error)* error_ = nullptr;
    decltype(openntc_adapter_create)* create_ = nullptr;
    decltype(openntc_adapter_destroy)* destroy_ = nullptr;
    decltype(openntc_adapter_decode_texels)* decodeTexels_ = nullptr;
    decltype(openntc_adapter_decode_mip)* decodeMip_ = nullptr;
    decltype(openntc_adapter_decode_slice)* decodeSlice_ = nullptr;
    decltype(openntc_adapter_decode_slice_mips)* decodeSliceMips_ = nullptr;
    decltype(openntc_adapter_encode_blocks)* encodeBlocks_ = nullptr;
    decltype(openntc_adapter_decode_textures)* decodeTextures_ = nullptr;
    decltype(openntc_adapter_filter)* filter_ = nullptr;
    std::vector<std::byte> file_;
    OpenntcAdapterSet* set_ = nullptr;
};

} // namespace

std::unique_ptr<Subject> MakeLibrarySubject(const std::string& path) {
    return std::make_unique<LibrarySubject>(path);
}

} // namespace openntc::conformance
