// SPDX-License-Identifier: MIT
#include <openntc/core/FileStream.h>
#include <openntc/openntc.h>

int GetWidth(const char* path) {
    auto file = openntc::FileReader::Open(path);
    if (!file)
        return -1;
    const auto set = openntc::TextureSetMetadata::Load(*file);
    return set ? set->GetDesc().width : -1;
}
