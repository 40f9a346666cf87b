// SPDX-License-Identifier: MIT
#include "Arguments.h"

#include "Python.h"

#include <limits>

namespace py = pybind11;

namespace openntc::python {

namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// NaN for what is no number, or is too large for one.
double ToDouble(const py::handle& value, bool isWhole) {
    if (!isWhole) {
        const double number = PyFloat_AsDouble(value.ptr());
        if (PyErr_Occurred() == nullptr)
            return number;
    } else if (const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()))) {
        const double number = PyLong_AsDouble(index.ptr());
        if (PyErr_Occurred() == nullptr)
            return number;
    }
    PyErr_Clear();
    return kNoNumber;
}

} // namespace

std::string Describe(const py::handle& value) {
    constexpr std::size_t kLongest = 60;
    const auto ascii = py::reinterpret_steal<py::object>(PyObject_ASCII(value.ptr()));
    if (!ascii)
        throw py::error_already_set();
    std::string text = ascii.cast<std::string>();
    for (char& c : text)
        c = c == '\n' ? ' ' : c;
    if (text.size() > kLongest)
        text = text.substr(0, kLongest) + "...";
    return text;
}

double GetNumber(const std::string& field, const py::handle& value, const tool::NumberLimits& limits,
                 bool isWhole) {
    const double number = ToDouble(value, isWhole);
    if (!tool::IsInside(number, limits, isWhole))
        throw PythonError(field + ": " + Describe(value) + ": " + tool::DescribeLimits(limits, isWhole));
    return number;
}

double GetNumberOrZero(const std::string& field, const py::handle& value, const tool::NumberLimits& limits,
                       bool isWhole) {
    return ToDouble(value, isWhole) == 0.0 ? 0.0 : GetNumber(field, value, limits, isWhole);
}

bool GetFlag(const std::string& field, const py::handle& value) {
    py::detail::make_caster<bool> caster;
    if (!caster.load(value, false))
        throw PythonError(field + ": " + Describe(value) + ": must be True or False");
    return static_cast<bool>(caster);
}

std::string GetText(const std::string& field, const py::handle& value) {
    if (!py::isinstance<py::str>(value))
        throw PythonError(field + ": " + Describe(value) + ": must be a string");
    return value.cast<std::string>();
}

} // namespace openntc::python
