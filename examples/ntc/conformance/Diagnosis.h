// SPDX-License-Identifier: MIT
// Which mistake explains a decoder's wrong values: the right cause, or none.
#pragma once

#include "Comparison.h"
#include "Subject.h"
#include "Suite.h"

#include <span>
#include <string>

namespace openntc::conformance {

/// When a value of a case is right.
struct Tolerance {
    const Model& model;
    const SuiteCase& suiteCase;
    Arithmetic arithmetic;

    /// `stored`: the output before conversion to linear.
    bool Accepts(std::size_t channel, float actual, float expected, float stored) const;
};

/// What the decoder gave for some texels of a case, wrong and right ones.
struct Evidence {
    std::span<const ValueRecord> records;
    std::span<const Outputs> values;
    std::span<const std::size_t> sample; ///< indices of records to look at
};

/// Over a run: a mistake that explained one case is tried first with the next.
class Diagnosis {
public:
    /// The cause, if exactly one mistake gives all values of the sample, or one that explained a case before.
    std::string Find(const Tolerance& tolerance, const Evidence& evidence);

private:
    Mistake known_ = Mistake::None;
};

} // namespace openntc::conformance
