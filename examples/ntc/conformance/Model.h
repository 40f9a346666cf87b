// SPDX-License-Identifier: MIT
// An independent decoder, written from the format specification in plain integers and double precision, with a reader of
// files of its own: it shares no code with the loader, the shaders and the fast decoder. Three uses: tests compare every
// decoder with it; it can make one deliberate mistake, which tests the conformance suite itself; and the suite asks which
// mistake would explain a decoder's wrong values.
#pragma once

#include "ModelMistakes.h"
#include "ModelNumbers.h"

#include "openntc/container/Document.h"
#include "openntc/decode/DecodeTypes.h"

#include <array>
#include <cstddef>
#include <memory>
#include <span>

namespace openntc::conformance {

/// How texels are asked for: decoders take different paths for lists, whole mips and slices.
enum class RequestKind : std::uint8_t { Texels, WholeMip, Slice };

/// One texel of a request.
struct ModelRequest {
    DecodeMath math = DecodeMath::Int8;
    bool linear = false;
    int mip = 0;
    int x = 0;
    int y = 0;
    RequestKind kind = RequestKind::Texels;
    Rect slice{};      ///< of slices: the rectangle that is asked for, in texels of sliceMip
    int sliceMip = 0;  ///< the first mip of the slice, in texels of which the rectangle is given
    int sliceMips = 1; ///< how many mips it has
};

/// The texels that a slice holds of the mip `level` mips below its first, which has width x height texels: those that
/// the rectangle lies on, as far as the mip has them. Its width or height is 0 where the mip ends before.
Rect GetSlicePart(const Rect& slice, int level, int width, int height);

struct ModelSet;

/// Decodes single texels of one set.
class Model {
public:
    /// `file` holds every byte of a valid file and must outlive the model. Throws std::runtime_error if it cannot be
    /// read.
    explicit Model(std::span<const std::byte> file);
    ~Model();
    Model(Model&&) noexcept;
    Model& operator=(Model&&) noexcept;

    /// The 16 outputs of one texel. The set must have the weights that the maths mode reads, and the texel must lie
    /// within +-2^22. Conversion to linear is computed in double precision and rounded once.
    std::array<float, 16> Decode(const ModelRequest& request, Mistake mistake = Mistake::None) const;
    std::array<float, 16> Decode(DecodeMath math, bool linear, int mip, int x, int y,
                                 Mistake mistake = Mistake::None) const {
        return Decode({math, linear, mip, x, y}, mistake);
    }

    /// For mistakes of MistakeKind::State: what a decoder keeps of the set before in place of this one's.
    void KeepFrom(const Model& before, Mistake mistake);

    /// The set as it is in the file, without mistakes.
    const ModelSet& GetSet() const { return *set_; }

private:
    const ModelSet& GetSet(Mistake mistake) const;

    std::span<const std::byte> file_;
    std::unique_ptr<ModelSet> set_;
    // The set with the mistake that was asked for last.
    mutable Mistake edited_ = Mistake::None;
    mutable std::unique_ptr<ModelSet> editedSet_;
};

/// Stored to linear in double precision. `colorSpace`: NTC_COLOR_SPACE_*.
double ConvertToLinear(double stored, ColorSpace colorSpace);

} // namespace openntc::conformance
