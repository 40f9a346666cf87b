# SPDX-License-Identifier: MIT
# Shader tests dispatch on lavapipe (or the device named by OPENNTC_TEST_DEVICE) with the validation layer on.
if(NOT TARGET openntc_vulkan_harness)
  add_subdirectory("${PROJECT_SOURCE_DIR}/examples/vulkan_harness" "${PROJECT_BINARY_DIR}/examples/vulkan_harness")
endif()
if(TARGET openntc_vulkan_harness)
  openntc_add_test(NAME shader LABEL shader DIRECTORY shader
    LIBRARIES openntc::decode openntc_vulkan_harness)
  openntc_add_shaders(TARGET shader HEADER_NAME harness_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/Fill.comp" DEFINES FACTOR={3,5} OFFSET)
  openntc_add_shaders(TARGET shader HEADER_NAME function_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/Functions.comp"
    NETWORK_VERSIONS LARGE MATH INT8 DEFINES NTC_DOT4_SPIRV={,1})
  # The layout test reads the permutations of the harness too.
  target_include_directories(shader PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader"
    $<TARGET_PROPERTY:openntc_vulkan_harness,INCLUDE_DIRECTORIES>)
endif()
