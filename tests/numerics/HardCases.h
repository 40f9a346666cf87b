// SPDX-License-Identifier: MIT
// The catalogue of hard cases. Adding one: a function that measures, and an entry in the table of its file.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace numerics {

struct Measurement {
    double worst = 0;
    std::string note; ///< further figures, for the log
};

struct HardCase {
    const char* name;
    const char* breaks; ///< what goes wrong
    const char* whom;   ///< where
    const char* why;    ///< and why it does not here
    double bound;       ///< the largest allowed error; 0: bit for bit
    Measurement (*measure)();
};

std::span<const HardCase> ListGeometryCases();
std::span<const HardCase> ListSliceCases();
std::span<const HardCase> ListTileCases();
std::span<const HardCase> ListFilterCases();
std::span<const HardCase> ListBlockCases();
std::span<const HardCase> ListWeightCases();
std::span<const HardCase> ListActivationCases();
std::span<const HardCase> ListFormatCases();
std::span<const HardCase> ListColorCases();
std::span<const HardCase> ListDeterminismCases();
std::span<const HardCase> ListEncoderCases();

std::vector<HardCase> ListHardCases();

/// A hard case that the requirements or the format specification name, and what covers it.
struct AuditRow {
    const char* what;
    const char* cases; ///< of this catalogue, joined by ", "
    const char* tests; ///< other files in tests/, joined by ", "
};

std::span<const AuditRow> ListAudit();

} // namespace numerics
