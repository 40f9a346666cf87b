# SPDX-License-Identifier: MIT
set(fuzz_temperature "")
if(NOT OPENNTC_SANITIZE) # there with every check
  set(fuzz_temperature WARM)
endif()
openntc_add_test(${fuzz_temperature} NAME fuzz_load LABEL fuzz DIRECTORY fuzz LIBRARIES openntc::decode)
if(OPENNTC_SANITIZE)
  # Five times faster; what UndefinedBehaviorSanitizer checks is there before the optimiser, and of AddressSanitizer's checks it
  # takes away those of loads that nothing uses. The unit tests of the same headers are not optimised.
  target_compile_options(fuzz_load PRIVATE -O1)
  # Each run has another seed, so that what one leaves out another has.
  set_tests_properties(fuzz_load PROPERTIES ENVIRONMENT OPENNTC_FUZZ_COUNT=20000)
  openntc_say_skipped(fuzz fuzz_load_left_out "fuzz_load: 180 000 of 200 000 mutations: minutes under sanitizers")
endif()

option(OPENNTC_BUILD_FUZZERS "Build the libFuzzer target (clang only), for longer runs than the tests make" OFF)
if(OPENNTC_BUILD_FUZZERS)
  add_executable(load_fuzzer "${CMAKE_CURRENT_SOURCE_DIR}/fuzz/libfuzzer/load_fuzzer.cpp")
  target_link_libraries(load_fuzzer PRIVATE openntc_warnings openntc::decode)
  target_include_directories(load_fuzzer PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
  target_compile_options(load_fuzzer PRIVATE -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all)
  target_link_options(load_fuzzer PRIVATE -fsanitize=fuzzer,address,undefined)
endif()
