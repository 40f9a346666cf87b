# SPDX-License-Identifier: MIT
# `cmake --install` and the package that find_package(openntc) finds.
include_guard(GLOBAL)
include(CMakePackageConfigHelpers)

set(OPENNTC_CONFIG_DIR "${CMAKE_INSTALL_DATADIR}/cmake/openntc")

install(DIRECTORY include/openntc DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(DIRECTORY shaders/openntc DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc/shaders")
install(TARGETS openntc openntc_shaders openntc_encode EXPORT openntcTargets)
install(EXPORT openntcTargets NAMESPACE openntc:: DESTINATION "${OPENNTC_CONFIG_DIR}")
# On its own, because whether a user has GLM shows where the package is found.
if(TARGET openntc_decode)
  install(TARGETS openntc_decode EXPORT openntcDecodeTargets)
  install(EXPORT openntcDecodeTargets NAMESPACE openntc:: DESTINATION "${OPENNTC_CONFIG_DIR}")
endif()

configure_package_config_file(cmake/OpenNTCConfig.cmake.in "${PROJECT_BINARY_DIR}/openntcConfig.cmake"
  INSTALL_DESTINATION "${OPENNTC_CONFIG_DIR}" PATH_VARS CMAKE_INSTALL_DATADIR)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/openntcConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES
  "${PROJECT_BINARY_DIR}/openntcConfig.cmake"
  "${PROJECT_BINARY_DIR}/openntcConfigVersion.cmake"
  cmake/OpenNTCDependencies.cmake
  cmake/OpenNTCShaders.cmake
  cmake/OpenNTCShaderCompilers.cmake
  cmake/OpenNTCShaderList.cmake
  cmake/OpenNTCShaderBlob.cmake
  cmake/OpenNTCEmbedShader.cmake
  cmake/OpenNTCShaderIndex.cpp.in
  cmake/OpenNTCShaderIndex.h.in
  DESTINATION "${OPENNTC_CONFIG_DIR}")
install(FILES LICENSE THIRD_PARTY.md DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc")
