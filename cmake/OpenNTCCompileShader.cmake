# SPDX-License-Identifier: MIT
# Script: compiles a permutation, checks it and, if OPENNTC_EMBED names a file, writes it there as the initialisers of a C++
# array. An error is the compiler's, behind what was compiled; of a failed #error only that line, because glslang goes on.
# cmake -DOPENNTC_SOURCE=a.comp -DOPENNTC_OUTPUT=a.spv -DOPENNTC_LABEL="a.comp X=1" -DOPENNTC_VALIDATOR=spirv-val
#   -DOPENNTC_ENVIRONMENT=vulkan1.1 -DOPENNTC_EMBED=a.spv.inc -P OpenNTCCompileShader.cmake -- glslangValidator OPTIONS…
# OPENNTC_STORED names a file that holds the SPIR-V already.
# The environment's OPENNTC_SHADER_CACHE names a folder where results are kept and looked up by content (OpenNTCShaderCache.cmake).
cmake_minimum_required(VERSION 3.25)
include("${CMAKE_CURRENT_LIST_DIR}/OpenNTCShaderCommand.cmake")
openntc_read_shader_command()

set(kept "")
set(keeps FALSE)
if(NOT "$ENV{OPENNTC_SHADER_CACHE}" STREQUAL "" AND NOT OPENNTC_STORED)
  include("${CMAKE_CURRENT_LIST_DIR}/OpenNTCShaderCache.cmake")
  openntc_prepare_shader_cache()
  openntc_find_cached_shader(kept)
  set(keeps TRUE)
endif()
if(kept)
  set(keeps FALSE)
elseif(OPENNTC_STORED)
  file(COPY_FILE "${OPENNTC_STORED}" "${OPENNTC_OUTPUT}")
  file(WRITE "${OPENNTC_OUTPUT}.d" "${OPENNTC_OUTPUT}: ${OPENNTC_STORED}\n")
else()
  openntc_ask_for_includes("")
  execute_process(COMMAND ${command} --depfile "${OPENNTC_OUTPUT}.d" -o "${OPENNTC_OUTPUT}" "${source}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  openntc_fail_on("${result}" "${output}" "${compiler}")
  if(output MATCHES "[^ \n]")
    message(NOTICE "${output}")
    set(keeps FALSE) # what the compiler has to say, it is to say each time
  endif()
endif()
if(OPENNTC_VALIDATOR AND NOT kept)
  execute_process(COMMAND "${OPENNTC_VALIDATOR}" --target-env "${OPENNTC_ENVIRONMENT}" "${OPENNTC_OUTPUT}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  openntc_fail_on("${result}" "${output}" "${OPENNTC_VALIDATOR}")
endif()
if(OPENNTC_EMBED)
  if(kept AND EXISTS "${kept}.inc")
    file(COPY_FILE "${kept}.inc" "${OPENNTC_EMBED}")
  else()
    file(READ "${OPENNTC_OUTPUT}" bytes HEX)
    string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${bytes}")
    file(WRITE "${OPENNTC_EMBED}" "${words}")
  endif()
endif()
if(keeps)
  openntc_keep_shader()
endif()
