// SPDX-License-Identifier: MIT
#include "Progress.h"

#include "Json.h"
#include "Output.h"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <utility>

#if defined(_WIN32)
#include <io.h>
#define OPENNTC_ISATTY _isatty
#else
#include <unistd.h>
#define OPENNTC_ISATTY isatty
#endif

namespace openntc::tool {

namespace {

constexpr std::chrono::milliseconds kInterval{250};

} // namespace

bool IsTerminal() {
    return OPENNTC_ISATTY(2) != 0;
}

void PrintWarning(const std::string& text, bool json) {
    if (!json) {
        std::fprintf(stderr, "ntc: warning: %s\n", Printable(text).c_str());
        return;
    }
    rapidjson::StringBuffer buffer;
    rapidjson::Writer<rapidjson::StringBuffer> writer(buffer);
    const std::string valid = MakeValidUtf8(text);
    writer.StartObject();
    writer.Key("event");
    writer.String("warning");
    writer.Key("text");
    writer.String(valid.data(), static_cast<rapidjson::SizeType>(valid.size()));
    writer.EndObject();
    std::fprintf(stderr, "%s\n", buffer.GetString());
}

bool LogPace::IsDue(double seconds) {
    constexpr double kGrowth = 1.5, kLongest = 300.0;
    if (seconds < next_)
        return false;
    next_ = std::min(seconds * kGrowth, seconds + kLongest);
    return true;
}

Progress::Progress(std::string activity, std::uint64_t total, bool json)
    : activity_(std::move(activity)), total_(total), json_(json), terminal_(IsTerminal()),
      last_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
    if (shown_ && !json_)
        std::fputs("\r\033[K", stderr);
}

void Progress::Advance(std::uint64_t units) {
    done_ += units;
    const auto now = std::chrono::steady_clock::now();
    if ((!json_ && !terminal_) || now - last_ < kInterval)
        return;
    last_ = now;
    shown_ = true;
    if (json_)
        std::fprintf(stderr,
                     "{\"event\":\"progress\",\"activity\":\"%s\",\"done\":%" PRIu64 ",\"total\":%" PRIu64
                     "}\n",
                     activity_.c_str(), done_, total_);
    else
        std::fprintf(stderr, "\r%s: %3.0f %%", activity_.c_str(),
                     total_ == 0 ? 100.0 : 100.0 * static_cast<double>(done_) / static_cast<double>(total_));
}

} // namespace openntc::tool
