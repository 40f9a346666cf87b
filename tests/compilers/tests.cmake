# SPDX-License-Identifier: MIT
# What other compilers make of the shader headers: tests/compilers/run.sh builds this program and drives it.
if(TARGET openntc_vulkan_harness)
  add_executable(compilers_texels EXCLUDE_FROM_ALL compilers/texels.cpp shader/TestDevice.cpp)
  target_link_libraries(compilers_texels PRIVATE openntc_test_main openntc_warnings openntc_warm openntc::decode openntc_vulkan_harness)
  target_include_directories(compilers_texels PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}")
  target_compile_definitions(compilers_texels PRIVATE "OPENNTC_DEFAULT_SHARED_DIR=\"${OPENNTC_SHARED_DIR}\"")
endif()

# The README's table is what the last full run of that script saw.
find_program(OPENNTC_NODE node)
mark_as_advanced(OPENNTC_NODE)
if(OPENNTC_NODE)
  add_test(NAME compilers_table COMMAND "${OPENNTC_NODE}" "${CMAKE_CURRENT_SOURCE_DIR}/compilers/table.mjs" check)
  add_test(NAME compilers_summary COMMAND "${OPENNTC_NODE}" "${CMAKE_CURRENT_SOURCE_DIR}/compilers/summary_test.mjs")
  set_tests_properties(compilers_table compilers_summary PROPERTIES LABELS house)
else()
  openntc_say_skipped(house compilers_table "the README's table of shader compilers: node is not installed")
endif()
