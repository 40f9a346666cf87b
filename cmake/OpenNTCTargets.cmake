# SPDX-License-Identifier: MIT
# The INTERFACE targets that users link: the product itself builds nothing.
include_guard(GLOBAL)

include("${CMAKE_CURRENT_LIST_DIR}/OpenNTCDependencies.cmake")
if(OPENNTC_MISSING_DEPENDENCIES)
  message(FATAL_ERROR "OpenNTC lacks headers:\n${OPENNTC_MISSING_DEPENDENCIES}")
endif()
find_package(Threads REQUIRED)

# Runtime: container, texture set, inference. RapidJSON and tl::expected only.
add_library(openntc INTERFACE)
add_library(openntc::openntc ALIAS openntc)
target_compile_features(openntc INTERFACE cxx_std_20)
target_include_directories(openntc INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/shaders>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_DATADIR}/openntc/shaders>)
target_link_libraries(openntc INTERFACE openntc::rapidjson openntc::expected)

# Shaders: include path for GLSL, HLSL and C++; openntc_add_shaders() compiles permutations.
add_library(openntc_shaders INTERFACE)
add_library(openntc::shaders ALIAS openntc_shaders)
set_target_properties(openntc_shaders PROPERTIES EXPORT_NAME shaders)
target_include_directories(openntc_shaders INTERFACE
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/shaders>
  $<INSTALL_INTERFACE:${CMAKE_INSTALL_DATADIR}/openntc/shaders>)

# CPU decoders: the shader source through GLM, and the fast one. Without GLM there is none, and linking it is an error.
if(OPENNTC_MISSING_FOR_DECODE)
  if(OPENNTC_BUILD_TESTS OR OPENNTC_BUILD_EXAMPLES)
    message(FATAL_ERROR "OpenNTC's tests and examples lack headers:\n${OPENNTC_MISSING_FOR_DECODE}")
  endif()
  message(STATUS "OpenNTC: no openntc::decode, which lacks headers:\n${OPENNTC_MISSING_FOR_DECODE}")
  return()
endif()
add_library(openntc_decode INTERFACE)
add_library(openntc::decode ALIAS openntc_decode)
set_target_properties(openntc_decode PROPERTIES EXPORT_NAME decode)
target_link_libraries(openntc_decode INTERFACE openntc openntc_shaders openntc::glm Threads::Threads)
