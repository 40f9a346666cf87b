// SPDX-License-Identifier: MIT
#include "report/Host.h"

#include <cstdlib>
#include <ctime>

namespace openntc::report {

std::string GetDate() {
    const std::time_t now = std::time(nullptr);
    char text[32] = {};
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&now));
    return text;
}

double GetLoad() {
#if !defined(_WIN32)
    double load = 0;
    if (getloadavg(&load, 1) == 1)
        return load;
#endif
    return 0;
}

} // namespace openntc::report
