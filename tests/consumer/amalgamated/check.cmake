# SPDX-License-Identifier: MIT
# cmake -DROOT=… -DDIRECTORY=… -DCOMPILER=… -DCOPY=… -DFILE=v1.ntc -DGLSLANG=… -P: all headers as one file compile in two
# sources of a program and decode; the shader headers as one file compile to the same SPIR-V as apart.
find_program(python python3)
if(NOT python)
  message("SKIP: consumer_amalgamated: no Python 3")
  return()
endif()
file(REMOVE_RECURSE "${DIRECTORY}")
file(MAKE_DIRECTORY "${DIRECTORY}")
set(headers openntc/openntc.h openntc/core/FileStream.h openntc/decode/FastDecoder.h openntc/decode/ReferenceDecoder.h)
set(amalgamate "${python}" "${ROOT}/cmake/amalgamate.py")
execute_process(COMMAND ${amalgamate} ${headers} -o "${DIRECTORY}/openntc_all.h" COMMAND_ERROR_IS_FATAL ANY)
# The programs of the other consumer tests, for which every header is the one file.
foreach(header ${headers})
  file(WRITE "${DIRECTORY}/include/${header}" "#include \"${DIRECTORY}/openntc_all.h\"\n")
endforeach()
execute_process(COMMAND "${COMPILER}" -std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror "-I${DIRECTORY}/include"
  "-I${COPY}/third_party" "-I${COPY}/for_decode" "${ROOT}/tests/consumer/program/main.cpp" "${ROOT}/tests/consumer/program/second.cpp" -pthread
  -o "${DIRECTORY}/consumer" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${DIRECTORY}/consumer" "${FILE}" COMMAND_ERROR_IS_FATAL ANY)

# Kernels of the block encoder take the guards of shader headers back, which the first header has taken in already.
execute_process(COMMAND ${amalgamate} openntc/openntc.h openntc/bc/BlockEncoder.h openntc/bc/BlockDecoder.h -o "${DIRECTORY}/openntc_blocks.h"
  COMMAND_ERROR_IS_FATAL ANY)
file(WRITE "${DIRECTORY}/blocks.cpp" "#include \"openntc_blocks.h\"\n")
execute_process(COMMAND "${COMPILER}" -std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -fsyntax-only
  "-I${COPY}/third_party" "-I${COPY}/for_decode" "${DIRECTORY}/blocks.cpp" COMMAND_ERROR_IS_FATAL ANY)

find_program(unifdef unifdef)
if(NOT unifdef)
  message("SKIP: consumer_amalgamated: shader headers: no unifdef")
  return()
endif()
set(entries openntc/Inference.h openntc/StochasticFiltering.h)
execute_process(COMMAND ${amalgamate} ${entries} --shaders -o "${DIRECTORY}/openntc_shaders.h" COMMAND_ERROR_IS_FATAL ANY)
set(apart "")
foreach(entry ${entries})
  string(APPEND apart "#include \"${entry}\"\n")
endforeach()
set(head "#version 460\n#extension GL_GOOGLE_include_directive : require\n")
file(READ "${CMAKE_CURRENT_LIST_DIR}/main.glsl" main)
file(WRITE "${DIRECTORY}/apart.comp" "${head}${apart}${main}")
file(WRITE "${DIRECTORY}/whole.comp" "${head}#include \"openntc_shaders.h\"\n${main}")
foreach(network 1 4 5 6)
  foreach(form apart whole)
    execute_process(COMMAND "${GLSLANG}" -V --target-env vulkan1.1 "-DNETWORK_VERSION=${network}" "-I${ROOT}/shaders"
      "-I${DIRECTORY}" "${DIRECTORY}/${form}.comp" -o "${DIRECTORY}/${form}.spv" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
    file(SHA256 "${DIRECTORY}/${form}.spv" ${form})
  endforeach()
  if(NOT apart STREQUAL whole)
    message(FATAL_ERROR "network ${network}: the one file compiles to other SPIR-V than the headers apart")
  endif()
endforeach()
