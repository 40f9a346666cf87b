# SPDX-License-Identifier: MIT
# Settings for our own tests and examples; users never see them.
include_guard(GLOBAL)

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(OPENNTC_SANITIZE "" CACHE STRING "Sanitizers for tests and examples: address, undefined, or both with a comma")
set(OPENNTC_SHARED_DIR "${PROJECT_SOURCE_DIR}/../shared" CACHE PATH
  "Folder with LibNTC's conformance vectors; tests that need it skip with a reason when it is absent")

# Most of what there is to compile is the same headers, again for every source; a unity build has them once for many.
# The test command, which compiles everything, asks for larger ones than a change of one source is to wait for.
if(NOT DEFINED CMAKE_UNITY_BUILD)
  set(CMAKE_UNITY_BUILD ${PROJECT_IS_TOP_LEVEL})
endif()
if(NOT DEFINED CMAKE_UNITY_BUILD_BATCH_SIZE)
  set(CMAKE_UNITY_BUILD_BATCH_SIZE 16)
endif()

# Half of a build's time is optimising tests and commands that run for milliseconds, so presets give the four kinds
# options of their own (after those of the build type). Who links openntc_cold, openntc_test, openntc_warm or openntc_hot, after
# openntc_warnings, says which kind it is.
set(OPENNTC_COLD_OPTIONS "" CACHE STRING "Compiler options of tests and commands that do little work")
set(OPENNTC_TEST_OPTIONS "" CACHE STRING "Compiler options of tests that do little work; empty: OPENNTC_COLD_OPTIONS")
set(OPENNTC_WARM_OPTIONS "" CACHE STRING
  "Compiler options of tests and examples that decode for seconds to compare with; empty: OPENNTC_HOT_OPTIONS")
set(OPENNTC_HOT_OPTIONS "" CACHE STRING "Compiler options of kernels whose speed or optimised code is what counts")
foreach(kind cold test warm hot)
  add_library(openntc_${kind} INTERFACE)
  string(TOUPPER "${kind}" name)
  if(kind STREQUAL "warm" AND OPENNTC_WARM_OPTIONS STREQUAL "")
    set(name HOT)
  elseif(kind STREQUAL "test" AND OPENNTC_TEST_OPTIONS STREQUAL "")
    set(name COLD)
  endif()
  target_compile_options(openntc_${kind} INTERFACE ${OPENNTC_${name}_OPTIONS})
endforeach()

add_library(openntc_warnings INTERFACE)
target_compile_options(openntc_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror)
if(OPENNTC_SANITIZE)
  target_compile_options(openntc_warnings INTERFACE -fsanitize=${OPENNTC_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_compile_options(openntc_warnings INTERFACE
      "-fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/tests/support/sanitizers.ignore")
  endif()
  target_link_options(openntc_warnings INTERFACE -fsanitize=${OPENNTC_SANITIZE})
endif()
