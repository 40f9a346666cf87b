// SPDX-License-Identifier: MIT
// The table of load_time, for people, for pages and for programs.
#pragma once

#include "LoadTimes.h"

#include <string>

namespace openntc::load_time {

std::string MakeText(const LoadTimes& times, const LoadOptions& options);
std::string MakeMarkdown(const LoadTimes& times, const LoadOptions& options);
/// schemas/load-time.schema.json
std::string MakeJson(const LoadTimes& times, const LoadOptions& options);

} // namespace openntc::load_time
