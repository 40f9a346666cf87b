# SPDX-License-Identifier: MIT
openntc_add_test(HOT NAME fuzz_load LABEL fuzz DIRECTORY fuzz LIBRARIES openntc::decode TIMEOUT 300)

option(OPENNTC_BUILD_FUZZERS "Build the libFuzzer target (clang only), for longer runs than the tests make" OFF)
if(OPENNTC_BUILD_FUZZERS)
  add_executable(load_fuzzer "${CMAKE_CURRENT_SOURCE_DIR}/fuzz/libfuzzer/load_fuzzer.cpp")
  target_link_libraries(load_fuzzer PRIVATE openntc_warnings openntc::decode)
  target_include_directories(load_fuzzer PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
  target_compile_options(load_fuzzer PRIVATE -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all)
  target_link_options(load_fuzzer PRIVATE -fsanitize=fuzzer,address,undefined)
endif()
