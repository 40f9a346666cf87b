# SPDX-License-Identifier: MIT
# An overlay port (`vcpkg install openntc --overlay-ports=openntc/cmake/vcpkg`): installs the tree that it lies in.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
set(VCPKG_BUILD_TYPE release) # headers only

vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DOPENNTC_BUILD_TESTS=OFF -DOPENNTC_BUILD_EXAMPLES=OFF -DOPENNTC_INSTALL=ON)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/openntc)
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
