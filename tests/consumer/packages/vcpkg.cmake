# SPDX-License-Identifier: MIT
# cmake -DPORT=cmake/vcpkg -DPREFIX=… -DBUILD=… -P: runs the port with stand-ins for vcpkg's functions as its manual describes
# them, since vcpkg is no package of Debian's.
function(vcpkg_cmake_configure)
  cmake_parse_arguments(ARG "" "SOURCE_PATH" "OPTIONS" ${ARGN})
  execute_process(COMMAND "${CMAKE_COMMAND}" -S "${ARG_SOURCE_PATH}" -B "${BUILD}" "-DCMAKE_INSTALL_PREFIX=${PREFIX}" ${ARG_OPTIONS}
    OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_install)
  execute_process(COMMAND "${CMAKE_COMMAND}" --install "${BUILD}" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()
function(vcpkg_cmake_config_fixup)
  cmake_parse_arguments(ARG "" "CONFIG_PATH" "" ${ARGN})
  if(NOT EXISTS "${PREFIX}/${ARG_CONFIG_PATH}/openntcConfig.cmake")
    message(FATAL_ERROR "portfile.cmake: ${ARG_CONFIG_PATH}: there is no openntcConfig.cmake")
  endif()
endfunction()
function(vcpkg_install_copyright)
  cmake_parse_arguments(ARG "" "" "FILE_LIST" ${ARGN})
  file(READ "${ARG_FILE_LIST}" text)
endfunction()
include("${PORT}/portfile.cmake")

file(READ "${PORT}/vcpkg.json" manifest)
string(JSON version GET "${manifest}" version)
file(STRINGS "${PORT}/../../CMakeLists.txt" project REGEX "^project\\(openntc VERSION")
if(NOT project MATCHES "VERSION ${version} ")
  message(FATAL_ERROR "vcpkg.json: version ${version} is not that of CMakeLists.txt: ${project}")
endif()
