// SPDX-License-Identifier: MIT
#include "InputFile.h"

#include "Failure.h"
#include "Output.h"

#include "openntc/core/FileStream.h"

#include <algorithm>
#include <cerrno>
#include <cinttypes>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <system_error>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#endif

namespace openntc::tool {

namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

/// An input being read, with the bytes that were looked at before.
struct OpenInput {
    File file{nullptr, &std::fclose};
    std::vector<std::byte> beginning;
};

// Pipes that were looked at. `ntc compare` of two pipes is the only user, but jobs of convert-gltf read in
// parallel.
std::mutex peekedMutex;
std::map<std::string, OpenInput> peeked;

OpenInput Open(const std::string& path) {
    if (IsPipe(path)) {
        const std::lock_guard lock(peekedMutex);
        if (auto found = peeked.find(path); found != peeked.end()) {
            OpenInput input = std::move(found->second);
            peeked.erase(found);
            return input;
        }
    }
    OpenInput input;
    if (path == "-") {
#if defined(_WIN32)
        _setmode(_fileno(stdin), _O_BINARY);
#endif
        input.file = File(stdin, [](std::FILE*) { return 0; });
        return input;
    }
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw CommandError(ExitCode::BadInput, path, "is a directory");
    input.file.reset(openntc::detail::OpenForReading(path));
    if (input.file == nullptr)
        throw CommandError(ExitCode::BadInput, path,
                           Format("cannot be opened for reading: %s", SystemReason(errno).GetText()));
    return input;
}

/// Appends up to `count` bytes; fewer at the end of the input.
std::size_t Append(std::FILE* file, std::size_t count, std::vector<std::byte>& bytes,
                   const std::string& name) {
    const std::size_t size = bytes.size();
    bytes.resize(size + count);
    errno = 0;
    const std::size_t read = std::fread(bytes.data() + size, 1, count, file);
    bytes.resize(size + read);
    if (std::ferror(file) != 0)
        throw CommandError(ExitCode::BadInput, name,
                           Format("cannot be read: %s", SystemReason(errno).GetText()));
    return read;
}

} // namespace

bool IsPipe(const std::string& path) {
    std::error_code ignored;
    const std::filesystem::file_type type = std::filesystem::status(path, ignored).type();
    return path == "-" || type == std::filesystem::file_type::fifo ||
           type == std::filesystem::file_type::character || type == std::filesystem::file_type::socket;
}

// Pipes have no size, and files in /proc claim to have none: read to the end.
std::vector<std::byte> ReadAll(const std::string& path, const InputLimits& limits) {
    constexpr std::size_t kChunk = 1u << 20;
    OpenInput input = Open(path);
    std::vector<std::byte> bytes = std::move(input.beginning);
    InputBound bound = limits.bound;
    std::size_t wanted = InputLimits::kBeginning;
    for (bool begun = false;; begun = true) {
        const std::size_t read = Append(input.file.get(), wanted, bytes, path);
        if (!begun && limits.accept)
            limits.accept(bytes, bound);
        if (bytes.size() > bound.bytes)
            throw CommandError(ExitCode::BadInput, path,
                               Format("size: more than %" PRIu64 " bytes", bound.bytes) + bound.reason);
        if (read < wanted)
            return bytes;
        // Growing by as much as there is keeps copies few; by no more than the limit keeps memory bounded.
        wanted = static_cast<std::size_t>(
            std::min<std::uint64_t>(std::max(kChunk, bytes.size()), bound.bytes + 1 - bytes.size()));
    }
}

std::vector<std::byte> PeekInput(const std::string& path, std::size_t count) try {
    OpenInput input = Open(path);
    std::vector<std::byte> bytes;
    Append(input.file.get(), count, bytes, path);
    if (IsPipe(path)) {
        input.beginning = bytes;
        const std::lock_guard lock(peekedMutex);
        peeked[path] = std::move(input);
    }
    return bytes;
} catch (const CommandError&) {
    return {};
}

void RefuseInputAsOutput(const std::string& option, const std::string& output,
                         std::span<const std::string> inputs) {
    for (const std::string& input : inputs) {
        std::error_code error;
        if (std::filesystem::equivalent(output, input, error) && !error)
            throw CommandError(ExitCode::Usage, option,
                               output + ": is an input" + (output == input ? "" : " (" + input + ")"));
    }
}

std::string ReadAllText(const std::string& path, const InputLimits& limits) {
    const std::vector<std::byte> bytes = ReadAll(path, limits);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

} // namespace openntc::tool
