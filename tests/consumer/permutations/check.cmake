# SPDX-License-Identifier: MIT
# Script: builds the project, runs it, then changes files and looks which permutations are compiled again.
# cmake -DSOURCE=dir -DDIRECTORY=build -DROOT=openntc -DGENERATOR=Ninja -DCXX=g++ [-DNTC=ntc] -P check.cmake
cmake_minimum_required(VERSION 3.25)
file(REMOVE_RECURSE "${DIRECTORY}")
file(COPY "${SOURCE}/shaders" DESTINATION "${DIRECTORY}")
set(shaders "${DIRECTORY}/shaders")
set(build "${DIRECTORY}/build")

execute_process(COMMAND "${CMAKE_COMMAND}" -G "${GENERATOR}" -S "${SOURCE}" -B "${build}" -DCMAKE_BUILD_TYPE=Debug
    "-DCMAKE_CXX_COMPILER=${CXX}" "-DOPENNTC_ROOT=${ROOT}" "-DSHADERS=${shaders}"
    "-DOPENNTC_COOPVEC_GLSLANG=${CMAKE_COMMAND}"
  OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
if(NOT output MATCHES "left out: COOPVEC_INT8 COOPVEC_FP8: cooperative vectors and matrices need GLSL and a glslang that knows [^\n]*OPENNTC_COOPVEC_GLSLANG")
  message(FATAL_ERROR "configuring does not say what is left out:\n${output}")
endif()

# Builds, and checks that exactly the `count` permutations whose comment matches `pattern` were compiled.
function(check_build what count pattern)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL "(SPIR-V|Text) [^\n]*" steps "${output}")
  list(FILTER steps EXCLUDE REGEX "[.]bin: ")
  list(LENGTH steps steps_count)
  set(others "${steps}")
  list(FILTER others EXCLUDE REGEX "${pattern}")
  if(NOT steps_count EQUAL count OR others)
    message(FATAL_ERROR "${what}: ${steps_count} permutations compiled, ${count} expected, all like ${pattern}:\n${output}")
  endif()
  message(STATUS "${what}: ${steps_count} permutations compiled")
endfunction()

# 8 in the blob, 10 listed, 2 in the header, 5 files, 5 texts.
check_build("first build" 30 ".")
check_build("nothing changed" 0 ".")

file(READ "${build}/blobs.txt" blobs)
separate_arguments(blobs)
execute_process(COMMAND "${build}/consumer" ${blobs} COMMAND_ERROR_IS_FATAL ANY)
list(GET blobs 0 blob)
file(SHA256 "${blob}" before)

# The command line writes the same bytes and names.
if(NTC)
  list(GET blobs 1 listed)
  cmake_path(GET blob PARENT_PATH directory)
  execute_process(COMMAND "${NTC}" compile-shaders "${shaders}/first.comp" "${shaders}/second.frag.hlsl"
      --network small,xlarge --math int8,coopvec_int8,coopvec_fp8 -D SHAPE={0,1} -I "${ROOT}/shaders"
      --blob "${DIRECTORY}/permutations.bin"
    COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${NTC}" compile-shaders --list "${shaders}/shaders.txt" -I "${ROOT}/shaders"
      --blob "${DIRECTORY}/listed.bin" --output-dir "${DIRECTORY}/files"
    COMMAND_ERROR_IS_FATAL ANY)
  # A glslang library that knows cooperative vectors compiles more than this build, which was denied them.
  file(STRINGS "${DIRECTORY}/permutations.bin" first_lines LIMIT_COUNT 3)
  if(NOT first_lines MATCHES "NTC_MATH=6")
    file(COPY_FILE "${blob}" "${DIRECTORY}/permutations.bin")
  endif()
  foreach(pair "${blob};${DIRECTORY}/permutations.bin" "${listed};${DIRECTORY}/listed.bin")
    execute_process(COMMAND "${CMAKE_COMMAND}" -E compare_files ${pair} COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(GLOB files RELATIVE "${DIRECTORY}/files" "${DIRECTORY}/files/*.spv")
  file(GLOB expected RELATIVE "${build}/listed" "${build}/listed/*.spv")
  if(NOT files STREQUAL expected)
    message(FATAL_ERROR "names of files differ: ${files}; ${expected}")
  endif()
endif()

# Text without directives, by the command line the same: one permutation of the HLSL, which has no cooperative vectors, two of others.
file(GLOB flat RELATIVE "${build}/flat" "${build}/flat/*.glsl" "${build}/flat/*.hlsl" "${build}/flat/index.txt")
list(LENGTH flat count)
if(NOT count EQUAL 6)
  message(FATAL_ERROR "5 texts and an index expected: ${flat}")
endif()
if(NTC)
  execute_process(COMMAND "${NTC}" compile-shaders "${shaders}/first.comp" "${shaders}/second.frag.hlsl" "${shaders}/functions.h" --flatten
      --network small --math int8,coopvec_int8 -D SHAPE=0 -I "${ROOT}/shaders" --output-dir "${DIRECTORY}/flat"
    COMMAND_ERROR_IS_FATAL ANY)
  foreach(file IN LISTS flat)
    execute_process(COMMAND "${CMAKE_COMMAND}" -E compare_files "${build}/flat/${file}" "${DIRECTORY}/flat/${file}"
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
endif()

# first.comp: 4 in the blob, 2 listed, 1 in the header, 2 texts.
file(APPEND "${shaders}/first.h" "#undef FIRST_VALUE\n#define FIRST_VALUE 7\n")
check_build("first.h changed" 9 "(SPIR-V|Text) first.comp ")
file(SHA256 "${blob}" after)
if(before STREQUAL after)
  message(FATAL_ERROR "the blob was not written again")
endif()
# All but third.hlsl.
file(APPEND "${shaders}/both.h" "// changed\n")
check_build("both.h changed" 17 "(SPIR-V|Text) (first.comp|second.frag.hlsl)")
file(APPEND "${shaders}/third.hlsl" "// changed\n")
check_build("third.hlsl changed" 7 "SPIR-V third.hlsl")
file(APPEND "${shaders}/shaders.txt" "third.hlsl -T cs -E Fill -D SIZE=32 -D COLOUR=1\n")
check_build("a line more in the list" 1 "SPIR-V third.hlsl:Fill SIZE=32 COLOUR=1")

# A failed #error is one line, with the place in the shader, which is compiled from a copy that asks for #include.
file(READ "${shaders}/first.comp" text)
file(APPEND "${shaders}/first.comp" "#if SHAPE == 1\n#error SHAPE must be 0\n#endif\n")
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
string(REGEX REPLACE "[^\n]" "" lines "${text}")
string(LENGTH "${lines}" number)
math(EXPR number "${number} + 2")
if(result EQUAL 0 OR NOT output MATCHES "\n *first.comp NETWORK_VERSION=[14] NTC_MATH=1 SHAPE=1: ${shaders}/first.comp:${number}: '#error' : SHAPE must be 0 *\n"
    OR output MATCHES "compilation terminated|No code generated|Linking")
  message(FATAL_ERROR "a wrong define is not one clear line:\n${output}")
endif()
file(WRITE "${shaders}/first.comp" "${text}")

# A compiler that crashes is named.
if(NOT CMAKE_HOST_WIN32)
  file(WRITE "${DIRECTORY}/crash" "#!/bin/sh\nkill -SEGV $$\n")
  file(CHMOD "${DIRECTORY}/crash" PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  execute_process(COMMAND "${CMAKE_COMMAND}" "-DOPENNTC_GLSLANG_VALIDATOR=${DIRECTORY}/crash" "${build}"
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${CMAKE_COMMAND}" --build "${build}" OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE result)
  if(result EQUAL 0 OR NOT output MATCHES "\n *[a-z]+[.][a-zA-Z0-9_.=: ]+: ${DIRECTORY}/crash crashed [(]Segmentation fault[)]")
    message(FATAL_ERROR "a crash of the compiler is not named:\n${output}")
  endif()
endif()
