# SPDX-License-Identifier: MIT
# Script: writes the words of a little-endian SPIR-V file as the initialisers of a C++ array.
# cmake -DOPENNTC_EMBED_INPUT=a.spv -DOPENNTC_EMBED_OUTPUT=a.spv.inc -P OpenNTCEmbedShader.cmake
file(READ "${OPENNTC_EMBED_INPUT}" bytes HEX)
string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${bytes}")
file(WRITE "${OPENNTC_EMBED_OUTPUT}" "${words}")
