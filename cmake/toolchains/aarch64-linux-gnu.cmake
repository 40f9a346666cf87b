# SPDX-License-Identifier: MIT
# 64-bit Arm Linux; tests run under qemu-user where it is installed.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

include("${CMAKE_CURRENT_LIST_DIR}/cross-headers.cmake")

find_program(OPENNTC_QEMU_AARCH64 NAMES qemu-aarch64-static qemu-aarch64)
if(OPENNTC_QEMU_AARCH64)
  set(CMAKE_CROSSCOMPILING_EMULATOR "${OPENNTC_QEMU_AARCH64};-L;/usr/aarch64-linux-gnu")
endif()
