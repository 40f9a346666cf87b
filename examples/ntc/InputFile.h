// SPDX-License-Identifier: MIT
// Whole inputs in memory: files, pipes, standard input. One wording for what the system refuses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// The most bytes that an input may have; more is a CommandError(BadInput), which ends with the reason.
struct InputBound {
    std::uint64_t bytes = std::uint64_t{1} << 32;
    std::string reason = {};
};

/// What stops the reading of an input that is too large, endless, or not what was asked for.
struct InputLimits {
    InputBound bound = {};
    /// Given the first kBeginning bytes (fewer when the input is shorter) before the rest is read; may throw,
    /// and may lower the bound by what these bytes say.
    std::function<void(std::span<const std::byte>, InputBound&)> accept = {};

    static constexpr std::size_t kBeginning = 4096;
};

/// True for `-`, pipes and devices: they have no size, cannot seek and can be read once.
bool IsPipe(const std::string& path);

/// All bytes of a file or pipe, or of standard input for "-". Throws CommandError(BadInput) with the system's
/// reason.
std::vector<std::byte> ReadAll(const std::string& path, const InputLimits& limits = {});

/// The first `count` bytes, fewer when the input is shorter; a pipe keeps them for ReadAll. Empty when it
/// cannot be opened: ReadAll says why.
std::vector<std::byte> PeekInput(const std::string& path, std::size_t count);

/// Throws CommandError(Usage) about `option` if `output` is one of `inputs`: the same file, by whatever name
/// or link.
void RefuseInputAsOutput(const std::string& option, const std::string& output,
                         std::span<const std::string> inputs);

/// ReadAll as text, for JSON.
std::string ReadAllText(const std::string& path, const InputLimits& limits = {});

} // namespace openntc::tool
