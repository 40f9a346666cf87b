// SPDX-License-Identifier: MIT
// Options that several commands share.
#pragma once

#include "Decoder.h"
#include "NumberLimits.h"
#include "textures/BlockCoding.h"

#include <CLI/CLI.hpp>

#include <string>
#include <type_traits>
#include <vector>

namespace openntc::tool {

/// Input file, `-` for standard input.
void AddFileArgument(CLI::App& app, std::string& file);

/// Input files, `-` for standard input.
void AddFilesArgument(CLI::App& app, std::vector<std::string>& files);

/// Throws CommandError(Usage) if `-` is among the files more than once.
void CheckOneStandardInput(const std::vector<std::string>& files);

/// `--json`.
void AddJsonFlag(CLI::App& app, bool& json);

/// `--math int8|int8_half|fp8|fp16|fp32`, and with `backend` coopmat_int8 and coopmat_int8_half, which are int8 and
/// int8_half on cooperative matrices. Other modes of the design are refused with a message that says so.
void AddMathOption(CLI::App& app, std::optional<DecodeMath>& math, BackendOptions* backend = nullptr);

/// The effort with this name, or `whenEmpty`; a usage error about --quality for another name.
BlockEffort SelectEffort(const std::string& name, BlockEffort whenEmpty);

/// `--backend cpu|reference|vulkan` and `--device`.
void AddBackendOptions(CLI::App& app, BackendOptions& options);

/// A usage error: CommandError(Usage) about one option.
[[noreturn]] void FailUsage(const std::string& option, const std::string& text);

/// The number in `text`, all of it; a usage error `OPTION: TEXT: must be …` for anything else and outside the
/// limits.
double ParseNumber(const std::string& option, const std::string& text, const NumberLimits& limits,
                   bool isWhole);

/// `N (1 to 64)`, for help.
std::string DescribeNumber(const std::string& typeName, const NumberLimits& limits);

/// Four whole numbers with commas between them: x,y,w,h.
Rect ParseRect(const std::string& option, const std::string& text);

/// An option that takes one number of T within limits.
template <typename T>
CLI::Option* AddNumberOption(CLI::App& app, const std::string& name, T& value, const NumberLimits& limits,
                             const std::string& description, const std::string& typeName = "N") {
    return app
        .add_option_function<std::string>(
            name,
            [&value, name, limits](const std::string& text) {
                value = static_cast<T>(ParseNumber(name, text, limits, std::is_integral_v<T>));
            },
            description)
        ->type_name(DescribeNumber(typeName, limits));
}

/// For options that name a file or folder to write: `-` and nothing are refused, since no command writes
/// files to standard output.
const CLI::Validator& GetOutputNameCheck();

} // namespace openntc::tool
