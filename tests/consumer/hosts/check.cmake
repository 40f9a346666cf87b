# SPDX-License-Identifier: MIT
# cmake -DCOMPILER=… -DCOPY=… -DSOURCE=… -DDIRECTORY=… -DHOST=header -DORDERS="first;second" -DDEFINES=… -P: compiles use.cpp
# with all of our headers as -I, without warnings, below and above the host's header. Skips where the host is not installed.
cmake_minimum_required(VERSION 3.25)
set(flags -std=c++20 -fsyntax-only "-I${COPY}/include" "-I${COPY}/shaders" -isystem "${COPY}/third_party"
  -isystem "${COPY}/for_decode" "-I${DIRECTORY}" "-DHOST_HEADER=${HOST}" ${DEFINES})
# What a strict host compiles with. Left out: -Wfloat-equal (exact comparisons are what a bit-exact decoder is made of) and
# -Wuseless-cast (a cast to std::size_t is useless on one platform and needed on the next).
set(warnings -Wall -Wextra -Wpedantic -Werror -Wconversion -Wsign-conversion -Wshadow -Wold-style-cast -Wdouble-promotion
  -Wswitch-enum -Wcast-align -Wcast-qual -Wnull-dereference -Wundef -Wformat=2 -Wno-format-nonliteral
  -Wzero-as-null-pointer-constant -Wextra-semi)

file(MAKE_DIRECTORY "${DIRECTORY}")
file(WRITE "${DIRECTORY}/probe.cpp" "#include HOST_HEADER\n")
execute_process(COMMAND "${COMPILER}" ${flags} -E "${DIRECTORY}/probe.cpp" RESULT_VARIABLE result OUTPUT_QUIET ERROR_QUIET)
if(NOT result EQUAL 0)
  message(STATUS "SKIP: ${HOST}: not there for ${COMPILER}")
  return()
endif()
file(GLOB_RECURSE headers RELATIVE "${COPY}/include" "${COPY}/include/*.h")
list(FILTER headers EXCLUDE REGEX "core/(Hide|Restore)Macros.h$") # halves of a pair
list(LENGTH headers count)
if(count LESS 50)
  message(FATAL_ERROR "only ${count} headers in ${COPY}/include")
endif()
list(TRANSFORM headers REPLACE "(.+)" "#include \"\\1\"\n")
list(JOIN headers "" text)
file(WRITE "${DIRECTORY}/all_headers.h" "${text}")
foreach(order ${ORDERS})
  set(first 0)
  if(order STREQUAL "first")
    set(first 1)
  endif()
  execute_process(COMMAND "${COMPILER}" ${flags} ${warnings} "-DHOST_FIRST=${first}" "${SOURCE}/use.cpp"
    RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${HOST} ${order}: ${text}")
  endif()
  message(STATUS "${count} headers, ${HOST} ${order}: no warning")
endforeach()
