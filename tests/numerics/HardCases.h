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
std::span<const HardCase> ListWeightCases();
std::span<const HardCase> ListActivationCases();
std::span<const HardCase> ListFormatCases();
std::span<const HardCase> ListColorCases();
std::span<const HardCase> ListDeterminismCases();

std::vector<HardCase> ListHardCases();

} // namespace numerics
