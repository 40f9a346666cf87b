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
endif()
