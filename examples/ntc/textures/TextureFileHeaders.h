// SPDX-License-Identifier: MIT
// What stands before the texels of DDS and KTX2 files.
#pragma once

#include "textures/TextureFile.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace openntc::tool {

/// The 148 bytes of a DDS file with a DX10 header.
std::vector<std::byte> MakeDdsHeader(const TextureFileDesc& desc);

/// Header, level index, data format descriptor and key-value data of a KTX2 file. `storedBytes`: of each level, as in the
/// file.
std::vector<std::byte> MakeKtx2Header(const TextureFileDesc& desc, const TextureFileLayout& layout,
                                      std::span<const std::uint64_t> storedBytes);

/// The basic data format descriptor, with its total size in front (Khronos Data Format 1.3, section 5).
std::vector<std::uint32_t> MakeDataFormatDescriptor(const TextureFormat& format);

std::uint64_t GetDdsHeaderBytes();
std::uint64_t GetKtx2HeaderBytes(const TextureFileDesc& desc);

} // namespace openntc::tool
