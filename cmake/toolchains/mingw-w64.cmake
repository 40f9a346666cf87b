# SPDX-License-Identifier: MIT
# 64-bit Windows through mingw-w64; tests run under Wine where it is installed.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

include("${CMAKE_CURRENT_LIST_DIR}/cross-headers.cmake")

find_program(OPENNTC_WINE NAMES wine64 wine PATHS /usr/lib/wine)
if(OPENNTC_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR "sh;${CMAKE_CURRENT_LIST_DIR}/wine.sh;${OPENNTC_WINE}")
  find_program(OPENNTC_WINESERVER NAMES wineserver64 wineserver PATHS /usr/lib/wine)
endif()
