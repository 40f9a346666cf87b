# SPDX-License-Identifier: MIT
# Tests of the command line: its parts in process, and the program as users run it.
find_package(PNG)
if(TARGET ntc)
  # What takes half a minute and more under sanitizers; shorter cases do the same.
  set(cli_filter "")
  if(OPENNTC_SANITIZE)
    openntc_leave_out(cli cli_filter NAME cli WHY "takes long under sanitizers"
      CASES "a small report*" "a manifest: swizzle*" "a killed run goes on*" "bake: a hundred materials*" "the search for a quality*"
        "shader lists: CMake and ntc agree*" "discarded texels are outside*" "numbers outside their range*" "the materials of FlightHelmet*" "a weight moves quality*")
    openntc_leave_out(cli cli_filter NAME cli WHY "is the driver's work, which no sanitizer sees; 'load_time: a Vulkan device makes the blocks of the CPU' runs"
      CASES "load_time: BC7 with hints*" "load_time: a Vulkan device makes BC6H*")
    openntc_leave_out(cli cli_filter NAME cli WHY "is the driver's work for most of its time"
      CASES "ntc-renderer: a picture*" "ntc-viewer: a script*" "a small report of scenes*" "encode --device: kernel*"
        "bake --device: two at a time*" "convert-gltf --device makes*")
    openntc_leave_out(cli cli_filter NAME cli WHY "crashes on purpose, which sanitizers report"
      CASES "compile-shaders: a crash of the compiler*")
  endif()
  openntc_add_test(NAME cli LABEL cli DIRECTORY cli LIBRARIES ntc_tool PNG::PNG ARGUMENTS ${cli_filter} SECONDS 100
    APART bad_input_test.cpp bake_*.cpp convert_gltf_test.cpp encode_*.cpp gltf_*.cpp help_test.cpp slices_test.cpp
    DEFINITIONS DOCTEST_CONFIG_SUPER_FAST_ASSERTS "LOAD_TIME_PROGRAM=\"$<TARGET_FILE:load_time>\"" "NTC_PROGRAM=\"$<TARGET_FILE:ntc>\"" "NTC_SCHEMA_DIR=\"${PROJECT_SOURCE_DIR}/schemas\""
      "NTC_CXX_COMPILER=\"${CMAKE_CXX_COMPILER}\"" "NTC_INCLUDE_DIR=\"${PROJECT_SOURCE_DIR}/include\""
      "NTC_SHADER_DIR=\"${PROJECT_SOURCE_DIR}/shaders\"" "NTC_EXPECTED_DIR=\"${OPENNTC_EXPECTED_INCLUDE_DIR}\""
      "CMAKE_PROGRAM=\"${CMAKE_COMMAND}\"" "NTC_CMAKE_DIR=\"${PROJECT_SOURCE_DIR}/cmake\""
      "NTC_LIST_SHADERS=\"${CMAKE_CURRENT_SOURCE_DIR}/cli/list_shaders.cmake\""
      "NTC_SHADER_LISTS=\"${CMAKE_CURRENT_SOURCE_DIR}/cli/shader_lists.txt\"")
  add_dependencies(cli ntc load_time)
  if(OPENNTC_SANITIZE)
    target_compile_definitions(cli PRIVATE OPENNTC_TEST_SANITIZED)
  endif()
  if(OPENNTC_SANITIZE MATCHES "address")
    add_library(keep_libraries MODULE support/keep_libraries.cpp)
    add_dependencies(cli keep_libraries)
    set_tests_properties(cli cli_apart PROPERTIES ENVIRONMENT "LD_PRELOAD=$<TARGET_FILE:keep_libraries>")
  endif()
  if(TARGET knob_pictures AND NOT OPENNTC_SANITIZE)
    add_dependencies(tests_cli knob_pictures)
    add_test(NAME knob_pictures COMMAND knob_pictures "${CMAKE_CURRENT_BINARY_DIR}/knob_pictures" 1)
    set_tests_properties(knob_pictures PROPERTIES LABELS cli)
  endif()
  if(TARGET bench_encoder AND NOT WIN32 AND NOT OPENNTC_SANITIZE) # a sanitizer's memory is no encoding's
    add_dependencies(tests_cli bench_encoder)
    add_test(NAME bench_encoder_memory COMMAND bench_encoder --memory --sizes 16,32)
    set_tests_properties(bench_encoder_memory PROPERTIES LABELS cli PASS_REGULAR_EXPRESSION "32 x 32 . [1-9][0-9]* ")
    add_test(NAME bench_encoder_steps COMMAND bench_encoder none.json --device llvmpipe --steps 39 --batch 16384)
    set_tests_properties(bench_encoder_steps PROPERTIES LABELS cli PASS_REGULAR_EXPRESSION "--steps: 39: must be 40 or more")
  endif()
  if(TARGET ntc-renderer)
    add_dependencies(cli ntc-renderer)
    target_compile_definitions(cli PRIVATE "RENDERER_PROGRAM=\"$<TARGET_FILE:ntc-renderer>\""
      "$<$<BOOL:${OPENNTC_INSTALL}>:NTC_BUILD_DIR=\"${PROJECT_BINARY_DIR}\">")
  endif()
  if(TARGET ntc-viewer)
    add_dependencies(cli ntc-viewer)
    target_compile_definitions(cli PRIVATE "VIEWER_PROGRAM=\"$<TARGET_FILE:ntc-viewer>\"")
  endif()
  target_include_directories(cli SYSTEM PRIVATE "${OPENNTC_STB_INCLUDE_DIR}")
  if(OPENNTC_TINYEXR_INCLUDE_DIR AND OPENNTC_TINYEXR_LIBRARY)
    target_include_directories(cli SYSTEM PRIVATE "${OPENNTC_TINYEXR_INCLUDE_DIR}")
    target_link_libraries(cli PRIVATE "${OPENNTC_TINYEXR_LIBRARY}")
    target_compile_definitions(cli PRIVATE OPENNTC_TOOL_HAS_EXR=1)
  endif()
  if(OPENNTC_ZSTD_INCLUDE_DIR AND OPENNTC_ZSTD_LIBRARY)
    target_include_directories(cli SYSTEM PRIVATE "${OPENNTC_ZSTD_INCLUDE_DIR}")
    target_link_libraries(cli PRIVATE "${OPENNTC_ZSTD_LIBRARY}")
    target_compile_definitions(cli PRIVATE OPENNTC_TOOL_HAS_ZSTD=1)
  endif()
endif()
