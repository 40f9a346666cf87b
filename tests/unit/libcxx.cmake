# SPDX-License-Identifier: MIT
# The headers with LLVM's standard library, which Apple's, Android's, Emscripten's and some engines' toolchains bring: all
# of them compile, with and without exceptions and RTTI, and numbers are read and written as with libstdc++.
#   cmake -DSOURCE=<root> -DWORK=<folder> -DINCLUDES=<folders> -P libcxx.cmake
file(REMOVE_RECURSE "${WORK}")
file(WRITE "${WORK}/probe.cpp" "#include <cstddef>\n#ifndef _LIBCPP_VERSION\n#error\n#endif\nint main() {}\n")
set(compiler)
foreach(candidate clang++-20 clang++-19 clang++-18 clang++-17 clang++-16 clang++-15 clang++)
  execute_process(COMMAND ${candidate} -std=c++20 -stdlib=libc++ "${WORK}/probe.cpp" -o "${WORK}/probe"
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_QUIET)
  if(result EQUAL 0)
    set(compiler ${candidate})
    break()
  endif()
endforeach()
if(NOT compiler)
  message(STATUS "SKIP: no clang++ with libc++ (Debian: clang-19 libc++-19-dev)")
  return()
endif()
set(options -std=c++20 -stdlib=libc++ -Wall -Wextra -Wpedantic -Werror)
list(REMOVE_ITEM INCLUDES /usr/include) # found anyway; named, it would stand before the standard library
foreach(folder IN LISTS INCLUDES)
  list(APPEND options -isystem "${folder}")
endforeach()
list(APPEND options "-I${SOURCE}/include" "-I${SOURCE}/shaders" "-I${SOURCE}/tests")

file(GLOB_RECURSE headers RELATIVE "${SOURCE}/include" "${SOURCE}/include/*.h")
file(GLOB shader_headers RELATIVE "${SOURCE}/shaders" "${SOURCE}/shaders/openntc/*.h")
list(REMOVE_ITEM shader_headers openntc/InferenceCoopVec.h) # GLSL only
set(all "// SPDX-License-Identifier: MIT\n")
foreach(header IN LISTS headers shader_headers)
  string(APPEND all "#include \"${header}\"\n")
endforeach()
file(WRITE "${WORK}/all.cpp" "${all}")
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(SUBSTRING "${output}" 0 4000 output)
    message(FATAL_ERROR "${ARGN}:\n${output}")
  endif()
endfunction()
run(${compiler} ${options} -fsyntax-only "${WORK}/all.cpp")
run(${compiler} ${options} -fsyntax-only -fno-exceptions -fno-rtti "${WORK}/all.cpp")

set(container "${SOURCE}/tests/unit/container")
run(${compiler} ${options} -O0 -w "-DOPENNTC_DEFAULT_SHARED_DIR=\"${SOURCE}/../shared\""
  "-DOPENNTC_TEST_DATA_DIR=\"${SOURCE}/tests/data\""
  "${SOURCE}/tests/support/main.cpp" "${container}/decimal_test.cpp"
  "${container}/json_reader_test.cpp" "${container}/json_writer_test.cpp" -o "${WORK}/tests")
run("${WORK}/tests")
message(STATUS "${compiler}: all headers compile, and the tests of numbers and JSON pass")
