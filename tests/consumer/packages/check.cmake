# SPDX-License-Identifier: MIT
# cmake -DBUILD=… -DDIRECTORY=… -DCOMPILER=… -DSOURCE=tests/consumer -P: the .deb of the headers, unpacked anywhere, serves
# pkg-config, Meson and CMake. What has no program here is skipped and says so.
file(REMOVE_RECURSE "${DIRECTORY}")
cmake_path(GET CMAKE_COMMAND PARENT_PATH programs)
find_program(dpkg_deb dpkg-deb)
if(NOT dpkg_deb)
  message("SKIP: consumer_packages: no dpkg-deb")
  return()
endif()
execute_process(COMMAND "${programs}/cpack" -G DEB --config "${BUILD}/CPackConfig.cmake" -B "${DIRECTORY}"
  -D CPACK_COMPONENTS_ALL=development OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(GLOB package "${DIRECTORY}/libopenntc-dev_*_all.deb")
execute_process(COMMAND "${dpkg_deb}" -x "${package}" "${DIRECTORY}/unpacked" COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${dpkg_deb}" -f "${package}" Depends OUTPUT_VARIABLE depends COMMAND_ERROR_IS_FATAL ANY)
if(NOT depends MATCHES "rapidjson-dev" OR NOT depends MATCHES "libexpected-dev")
  message(FATAL_ERROR "${package}: Depends: ${depends}")
endif()

file(GLOB_RECURSE description "${DIRECTORY}/unpacked/*/openntc.pc")
cmake_path(GET description PARENT_PATH description_folder)
set(ENV{PKG_CONFIG_PATH} "${description_folder}")
find_program(pkg_config pkg-config)
if(pkg_config)
  execute_process(COMMAND "${pkg_config}" --cflags --libs openntc OUTPUT_VARIABLE flags COMMAND_ERROR_IS_FATAL ANY
    OUTPUT_STRIP_TRAILING_WHITESPACE)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  execute_process(COMMAND "${COMPILER}" -std=c++20 "${SOURCE}/program/runtime.cpp" ${flags} -o "${DIRECTORY}/runtime"
    COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${DIRECTORY}/runtime" COMMAND_ERROR_IS_FATAL ANY)
else()
  message("SKIP: consumer_packages: pkg-config: not installed")
endif()

find_program(meson meson)
if(meson)
  file(COPY "${SOURCE}/packages/meson.build" "${SOURCE}/program/runtime.cpp" DESTINATION "${DIRECTORY}/meson")
  set(ENV{CXX} "${COMPILER}")
  execute_process(COMMAND "${meson}" setup "${DIRECTORY}/meson/build" "${DIRECTORY}/meson"
    "-Dcmake_prefix_path=${DIRECTORY}/unpacked/usr" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND "${meson}" compile -C "${DIRECTORY}/meson/build" OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  foreach(program consumer consumer_cmake)
    execute_process(COMMAND "${DIRECTORY}/meson/build/${program}" COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
else()
  message("SKIP: consumer_packages: Meson: not installed")
endif()

execute_process(COMMAND "${CMAKE_COMMAND}" "-DPORT=${SOURCE}/../../cmake/vcpkg" "-DPREFIX=${DIRECTORY}/vcpkg"
  "-DBUILD=${DIRECTORY}/vcpkg_build" -P "${SOURCE}/packages/vcpkg.cmake" COMMAND_ERROR_IS_FATAL ANY)
