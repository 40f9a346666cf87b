// SPDX-License-Identifier: MIT
// Puts the exported suite together: sets, and cases of the set that was added or selected last.
#pragma once

#include "EditableSet.h"
#include "Suite.h"

#include <initializer_list>

namespace openntc::conformance {

inline constexpr LatentShape kPlainShape = {2, 8, 16, 2, 4};

/// A set of 16 channels.
SynthesisDesc Describe(std::uint32_t seed, int width, int height, int mips, const LatentShape& shape,
                       int networkVersion = NTC_NETWORK_UNKNOWN);

class SuiteBuilder {
public:
    Suite Take() { return std::move(suite_); }

    /// Throws std::runtime_error if our loader refuses the file.
    void AddSet(const std::string& name, std::vector<std::byte> bytes);

    /// Goes on with a set that was added before.
    void SelectSet(const std::string& name);

    /// The cases below use the set that was added or selected last. Every `stride`-th texel of the mips first ... last, and the last.
    std::vector<tool::Texel> ListTexels(int firstMip, int lastMip, int stride = 1) const;
    std::vector<tool::Texel> ListAllTexels(int stride = 1) const {
        return ListTexels(0, metadata_->GetDesc().mips - 1, stride);
    }
    /// Corners, borders and some of the inside of each mip: `count` texels a mip or fewer.
    std::vector<tool::Texel> ListFewTexels(int count) const;

    SuiteCase& AddCase(const std::string& name, DecodeMath math, std::vector<tool::Texel> texels,
                       const std::string& about);

    /// A case of texels that change when a decoder makes the mistakes: `count` for each of them. It has the name that
    /// ListMistakes gives for the first. Throws std::runtime_error if one changes no texel of the set.
    SuiteCase& AddMistakeCase(std::initializer_list<Mistake> mistakes, DecodeMath math,
                              const std::string& about, bool linear = false, std::size_t count = 24);
    /// The same with conversion to linear; the texels change by several times what decoders may differ by.
    SuiteCase& AddCurveCase(std::initializer_list<Mistake> mistakes, DecodeMath math,
                            const std::string& about);

    /// A case for FP8 hardware, which passes inside intervals.
    void AddHardwareCase(const std::string& name, std::vector<tool::Texel> texels, const std::string& about);

    /// A whole mip or, with `slice`, a rectangle of it; some of its texels are compared.
    SuiteCase& AddWholeMip(const std::string& name, DecodeMath math, int mip, std::vector<tool::Texel> texels,
                           const std::string& about);
    SuiteCase& AddSlice(const std::string& name, DecodeMath math, int mip, const Rect& slice,
                        const std::string& about);
    /// A slice of several mips, the rectangle in texels of firstMip; all texels that it holds are compared.
    SuiteCase& AddSliceMips(const std::string& name, DecodeMath math, int firstMip, int mips,
                            const Rect& slice, const std::string& about);

    std::size_t CountCases() const { return suite_.cases.size(); }
    /// Cases from `first` on need not be passed.
    void MakeOptional(std::size_t first);

    /// The texels of the case that was added last.
    std::vector<tool::Texel> GetLastTexels() const { return suite_.texels.back(); }
    const TextureSetMetadata& GetMetadata() const { return *metadata_; }

private:
    void Load(std::size_t set);
    SuiteCase& AddChanged(std::initializer_list<Mistake> mistakes, DecodeMath math, const std::string& about,
                          bool linear, bool isFine, std::size_t count);
    bool IsChanged(const Model& model, const ModelRequest& request, Mistake mistake, bool isFine) const;

    Suite suite_;
    std::size_t set_ = 0; // the current one
    std::optional<TextureSetMetadata> metadata_;
};

// Parts of the catalogue; those of version 2 come first and have not changed.
void AddVersion2(SuiteBuilder& builder); // SuiteVersion2.cpp
void AddShapes(
    SuiteBuilder& builder); // SuiteShapes.cpp: features, bits, grids, latent images, sizes, channels
void AddFileForms(SuiteBuilder& builder);   // SuiteForms.cpp: what a file may look like, 0.5 included
void AddNumberEnds(SuiteBuilder& builder);  // SuiteNumbers.cpp: weights, biases, scales, positions, colours
void AddRequests(SuiteBuilder& builder);    // SuiteRequests.cpp: whole mips, slices, texels outside
void AddGenerations(SuiteBuilder& builder); // SuiteGenerations.cpp: sets of generations 2 and 3
void AddSequence(
    SuiteBuilder& builder); // SuiteSequence.cpp: sets that differ from the one before in one thing

} // namespace openntc::conformance
