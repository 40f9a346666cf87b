# SPDX-License-Identifier: MIT
# Script: makes modules.tar.xz and manifest.json of what bench.txt lists, with a glslang and a spirv-val that know cooperative
# matrices; with -DCHECK=DIR it checks them. The work is examples/coopvec/update.cmake's, which says more.
#   cmake -DOPENNTC_COOPVEC_GLSLANG=glslang -DOPENNTC_SPIRV_VAL=spirv-val -P examples/coopmat/update.cmake
set(OPENNTC_STORED_FOLDER "${CMAKE_CURRENT_LIST_DIR}")
include("${CMAKE_CURRENT_LIST_DIR}/../coopvec/update.cmake")
