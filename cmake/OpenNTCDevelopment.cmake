# SPDX-License-Identifier: MIT
# Settings for our own tests and examples; users never see them.
include_guard(GLOBAL)

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(OPENNTC_SANITIZE "" CACHE STRING "Sanitizers for tests and examples: address, undefined, or both with a comma")
set(OPENNTC_SHARED_DIR "${PROJECT_SOURCE_DIR}/../shared" CACHE PATH
  "Folder with LibNTC's conformance vectors; tests that need it skip with a reason when it is absent")

# Half of a build's time is optimising tests and commands that run for milliseconds, so presets give the two kinds
# options of their own (after those of the build type).
set(OPENNTC_COLD_OPTIONS "" CACHE STRING "Compiler options of tests and commands that do little work")
set(OPENNTC_HOT_OPTIONS "" CACHE STRING "Compiler options of tests and tools that decode, encode or mutate for seconds")

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
