// SPDX-License-Identifier: MIT
// Options that several commands share.
#pragma once

#include "Decoder.h"

#include <CLI/CLI.hpp>

#include <string>
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

/// `--math int8|int8_half|fp8|fp16|fp32`. Other modes of the design are refused with a message that says so.
void AddMathOption(CLI::App& app, DecodeMath& math);

/// `--backend cpu|reference|vulkan` and `--device`.
void AddBackendOptions(CLI::App& app, BackendOptions& options);

/// A usage error: CommandError(Usage) about one option.
[[noreturn]] void FailUsage(const std::string& option, const std::string& text);

} // namespace openntc::tool
