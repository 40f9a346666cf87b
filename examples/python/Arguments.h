// SPDX-License-Identifier: MIT
// What callers pass, checked as the command line checks it. Errors: PythonError "FIELD: VALUE: must be …".
#pragma once

#include "NumberLimits.h"

#include <pybind11/pybind11.h>

#include <string>

namespace openntc::python {

/// A number inside the limits; whole ones are of Python's or NumPy's integers.
double GetNumber(const std::string& field, const pybind11::handle& value, const tool::NumberLimits& limits,
                 bool isWhole);

/// The same, or 0 for "not given".
double GetNumberOrZero(const std::string& field, const pybind11::handle& value,
                       const tool::NumberLimits& limits, bool isWhole);

/// True or False, of Python or NumPy.
bool GetFlag(const std::string& field, const pybind11::handle& value);

std::string GetText(const std::string& field, const pybind11::handle& value);

/// One line for errors, cut where it is long.
std::string Describe(const pybind11::handle& value);

} // namespace openntc::python
