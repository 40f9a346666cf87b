// SPDX-License-Identifier: MIT
// A decoder under test: one of ours, or somebody's behind an adapter. The suite knows nothing else of it.
#pragma once

#include "../Decoder.h"
#include "../TexelList.h"
#include "BlockSuite.h"
#include "Comparison.h"
#include "FilterSuite.h"
#include "Model.h"
#include "TextureSuite.h"

#include <array>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace openntc::conformance {

using Outputs = std::array<float, 16>;

/// Thrown by subjects: the case at hand ends with this outcome.
class SubjectError final : public std::exception {
public:
    enum class Kind {
        NotSupported,
        Failed, ///< it says so, and is still in step
        Broken, ///< it crashed, ended, or said what it was not asked for
        Hung,   ///< no answer in time
        NotRun  ///< it was not asked, because it hung before
    };

    SubjectError(Kind kind, std::string text) : kind_(kind), text_(std::move(text)) {}
    const char* what() const noexcept override { return text_.c_str(); }
    Kind GetKind() const noexcept { return kind_; }

private:
    Kind kind_;
    std::string text_;
};

/// A slice: a rectangle of mip firstMip and what lies below it in the next mips.
struct SliceRequest {
    int firstMip = 0;
    Rect rect;               ///< in texels of firstMip
    std::vector<Rect> parts; ///< of each mip the texels that are asked for; width or height may be 0

    std::size_t CountTexels() const;
    /// The place of a texel of the slice in the answer.
    std::size_t GetIndex(const tool::Texel& texel) const;
};

/// `getSize` gives width and height of a mip, as Rect or anything that has both.
template <typename GetSize>
SliceRequest MakeSliceRequest(int firstMip, int mips, const Rect& rect, const GetSize& getSize) {
    SliceRequest slice{firstMip, rect, {}};
    for (int level = 0; level < mips; ++level) {
        const auto& size = getSize(firstMip + level);
        slice.parts.push_back(GetSlicePart(rect, level, size.width, size.height));
    }
    return slice;
}

/// What a subject can do besides int8.
struct Capabilities {
    std::array<bool, 6> math{}; ///< per DecodeMath, which counts from 1
    bool linear = false;
    bool wholeMips = false; ///< DecodeMip; otherwise it is asked for lists
    bool slices = false;    ///< DecodeSlice of one mip
    bool sliceMips = false; ///< and of several
    bool outside = false;   ///< texels outside the mip
    bool blocks = false;    ///< EncodeBlocks
    bool textures = false;  ///< MakeTextures
    bool filtering = false; ///< FilterLookups
};

/// Member functions throw SubjectError, and tool::CommandError where nothing can go on (no device, interrupt).
class Subject {
public:
    virtual ~Subject() = default;

    /// One line for reports; known after the first Open. For our own decoders empty or the device.
    virtual std::string GetName() const = 0;
    virtual Capabilities GetCapabilities() = 0;
    /// How exact it must be: host libraries and devices differ in transcendental functions and subnormals.
    virtual Arithmetic GetArithmetic() const = 0;
    /// True if it reads files with this project's loader, so that metadata is worth checking beside it.
    virtual bool UsesOurLoader() const { return false; }

    /// Opens a file, which replaces the one before.
    virtual void Open(const std::string& path) = 0;
    /// All 16 outputs of each texel; texels are inside the image but with the capability `outside`.
    virtual std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                              const DecodeOptions& options) = 0;
    /// Every texel of a mip of that size, row by row.
    virtual std::vector<Outputs> DecodeMip(int mip, int width, int height, const DecodeOptions& options);
    /// Every texel of a slice, mip by mip and row by row; the rectangle lies inside its mip.
    virtual std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options);

    /// The blocks of a picture; no set need be open.
    virtual std::vector<std::byte> EncodeBlocks(const BlockRequest& request);
    /// Textures of a rectangle of the open set, which lies inside its mip.
    virtual Textures MakeTextures(const TextureRequest& request);
    /// The texels that lookups read; no set need be open.
    virtual FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups);

    /// Goes on as if nothing had been asked before: with a new process or a new decoder. False: it cannot.
    virtual bool Restart() { return false; }
    /// What it says or does within so many seconds without being asked: a line, a crash. Empty: nothing.
    virtual std::string WaitForUnasked(double) { return {}; }
    /// Says goodbye, and returns a line that it gave without being asked, or nothing.
    virtual std::string Finish() { return {}; }
};

/// One of our own decoders, in this process.
std::unique_ptr<Subject> MakeBackendSubject(const tool::BackendOptions& backend);

/// The independent model with a mistake, or None.
std::unique_ptr<Subject> MakeModelSubject(Mistake mistake);
/// The same with a mistake in block compression, in textures or in filtering alone.
std::unique_ptr<Subject> MakeModelSubject(BlockMistake mistake);
std::unique_ptr<Subject> MakeModelSubject(TextureMistake mistake);
std::unique_ptr<Subject> MakeModelSubject(FilterMistake mistake);

/// A shared library with the functions of openntc_adapter.h, in this process. Throws CommandError(BadInput) if it cannot
/// be loaded.
std::unique_ptr<Subject> MakeLibrarySubject(const std::string& path);

struct AdapterOptions {
    std::vector<std::string> command; ///< program and arguments
    double timeoutSeconds = 60;       ///< for each answer
};

/// A program that speaks the adapter protocol (docs/conformance.md). It starts with the first case and again after it
/// ended. Throws CommandError(BadInput) if it cannot be started at all.
std::unique_ptr<Subject> MakeAdapterSubject(const AdapterOptions& options);

/// The other end of the protocol: answers requests about `subject` from standard input until it ends.
void ServeSubject(Subject& subject);

} // namespace openntc::conformance
