# SPDX-License-Identifier: MIT
# `cmake --install` and the package that find_package(openntc) finds.
include_guard(GLOBAL)
include(CMakePackageConfigHelpers)

set(OPENNTC_CONFIG_DIR "${CMAKE_INSTALL_DATADIR}/cmake/openntc")
# `cmake --install build --component development` is what users' builds need; `tools` is the command line.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)

install(DIRECTORY include/openntc DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(FILES examples/adapter/openntc_adapter.h DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}/openntc/adapter")
install(DIRECTORY shaders/openntc DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc/shaders")
install(DIRECTORY schemas DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc")
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
  cmake/OpenNTCShaderPlan.cmake
  cmake/OpenNTCShaderBlob.cmake
  cmake/OpenNTCCompileShader.cmake
  cmake/OpenNTCFlattenShader.cmake
  cmake/OpenNTCShaderCommand.cmake
  cmake/OpenNTCShaderCache.cmake
  cmake/OpenNTCShaderIndex.cpp.in
  cmake/OpenNTCShaderIndex.h.in
  DESTINATION "${OPENNTC_CONFIG_DIR}")
# Found from where the file lies, so that the tree can be moved. Headers are the same for every architecture.
cmake_path(RELATIVE_PATH CMAKE_INSTALL_PREFIX BASE_DIRECTORY "${CMAKE_INSTALL_FULL_DATADIR}/pkgconfig"
  OUTPUT_VARIABLE OPENNTC_PC_TO_PREFIX)
configure_file(cmake/openntc.pc.in "${PROJECT_BINARY_DIR}/openntc.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/openntc.pc" DESTINATION "${CMAKE_INSTALL_DATADIR}/pkgconfig")
install(FILES LICENSE THIRD_PARTY.md DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc")

# The command line, if it is built: examples/ntc calls this. `ntc report --sources <prefix>/share/openntc` finds its shader.
function(openntc_install_tools)
  # Optional: headers can be installed without building anything.
  install(TARGETS ntc RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tools OPTIONAL)
  set(help_dir "${CMAKE_CURRENT_BINARY_DIR}/help") # made with the program, or not at all
  install(FILES "${help_dir}/ntc.1" COMPONENT tools DESTINATION "${CMAKE_INSTALL_MANDIR}/man1" OPTIONAL)
  install(FILES "${help_dir}/ntc.bash" COMPONENT tools RENAME ntc
    DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions" OPTIONAL)
  install(FILES "${help_dir}/_ntc" COMPONENT tools DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/site-functions" OPTIONAL)
  install(FILES "${help_dir}/ntc.fish" COMPONENT tools DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d" OPTIONAL)
  install(FILES "${PROJECT_SOURCE_DIR}/examples/ntc/report/ReportDecode.comp" COMPONENT tools
    DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc/examples/ntc/report")
endfunction()

# The renderer, likewise: it compiles its shaders when it runs, and its sample scene has texture sets.
function(openntc_install_renderer)
  foreach(program ntc-renderer ntc-viewer)
    if(TARGET ${program})
      install(TARGETS ${program} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT tools OPTIONAL)
    endif()
  endforeach()
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/renderer/shaders" COMPONENT tools
    DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc/examples/renderer")
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/examples/materials/data" COMPONENT tools
    DESTINATION "${CMAKE_INSTALL_DATADIR}/openntc/examples/materials")
endfunction()
