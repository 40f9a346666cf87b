// SPDX-License-Identifier: MIT
#include <openntc/decode/FastDecoder.h>
#include <openntc/decode/ReferenceDecoder.h>
#include <openntc/openntc.h>

int CountMipsInOtherTranslationUnit(const openntc::TextureSetMetadata& metadata);

int CountMipsInOtherTranslationUnit(const openntc::TextureSetMetadata& metadata) {
    return metadata.GetDesc().mips;
}
