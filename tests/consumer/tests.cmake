# SPDX-License-Identifier: MIT
# Projects of users, each configured, built and run by CTest.
set(consumer_source "${CMAKE_CURRENT_SOURCE_DIR}/consumer")
set(consumer_build "${CMAKE_CURRENT_BINARY_DIR}/consumer")
set(consumer_copy "${consumer_build}/copy")
set(consumer_prefix "${consumer_build}/prefix")
set(consumer_v1 "${consumer_build}/v1.ntc")
if(NOT TARGET synthesize)
  return()
endif()
find_program(OPENNTC_CLANG NAMES clang++-14 clang++)

# openntc_add_consumer(NAME PROJECT COMPILER [ARGUMENTS …] [OPTIONS …] [FIXTURE name] [TYPE Release])
# Neither optimised nor with debug information, but where an optimiser has something to find: warnings of g++, bits that must not
# change.
function(openntc_add_consumer name project compiler)
  cmake_parse_arguments(PARSE_ARGV 3 ARG "" "FIXTURE;TYPE" "OPTIONS;ARGUMENTS")
  if(NOT ARG_TYPE)
    set(ARG_TYPE None)
  endif()
  set(directory "${consumer_build}/${name}")
  add_test(NAME consumer_${name} COMMAND "${CMAKE_CTEST_COMMAND}"
    --build-and-test "${consumer_source}/${project}" "${directory}" --build-generator "${CMAKE_GENERATOR}"
    --build-options "-DCMAKE_BUILD_TYPE=${ARG_TYPE}" "-DCMAKE_CXX_COMPILER=${compiler}" "-DOPENNTC_ROOT=${PROJECT_SOURCE_DIR}"
    "-DOPENNTC_COPY=${consumer_copy}" ${ARG_OPTIONS}
    --test-command "${directory}/consumer" ${ARG_ARGUMENTS})
  set_tests_properties(consumer_${name} PROPERTIES LABELS consumer TIMEOUT 900 COST 20)
  set_tests_properties(consumer_${name} PROPERTIES FIXTURES_REQUIRED "consumer_v1;${ARG_FIXTURE}")
endfunction()

# The set V1 of the format specification, from our own writer; the programs check what it decodes to.
file(MAKE_DIRECTORY "${consumer_build}")
add_test(NAME consumer_v1 COMMAND synthesize v1 "${consumer_v1}")
set_tests_properties(consumer_v1 PROPERTIES LABELS consumer FIXTURES_SETUP consumer_v1)
set(consumer_gen3 "${consumer_build}/gen3.ntc")
foreach(set v2 gen3)
  add_test(NAME consumer_${set} COMMAND synthesize ${set} "${consumer_build}/${set}.ntc")
  set_tests_properties(consumer_${set} PROPERTIES LABELS consumer FIXTURES_SETUP consumer_${set})
endforeach()

if(TARGET engine_dropin)
  add_dependencies(tests_consumer engine_dropin)
  foreach(set v1 v2 gen3)
    add_test(NAME consumer_engine_dropin_${set} COMMAND engine_dropin "${consumer_build}/${set}.ntc" llvmpipe)
    set_tests_properties(consumer_engine_dropin_${set} PROPERTIES LABELS consumer FIXTURES_REQUIRED consumer_${set}
      SKIP_RETURN_CODE 4 TIMEOUT 300)
  endforeach()
endif()

foreach(version 43 33)
  if(TARGET opengl${version})
    add_dependencies(tests_consumer opengl${version})
    foreach(set v1 v2 gen3)
      add_test(NAME consumer_opengl${version}_${set} COMMAND opengl${version} "${consumer_build}/${set}.ntc")
      set_tests_properties(consumer_opengl${version}_${set} PROPERTIES LABELS consumer FIXTURES_REQUIRED consumer_${set}
        SKIP_RETURN_CODE 4 TIMEOUT 300)
    endforeach()
  endif()
endforeach()

add_test(NAME consumer_install COMMAND "${CMAKE_COMMAND}" --install "${PROJECT_BINARY_DIR}" --prefix "${consumer_prefix}")
set_tests_properties(consumer_install PROPERTIES LABELS consumer FIXTURES_SETUP consumer_prefix)
if(TARGET ntc)
  add_dependencies(tests_consumer ntc) # which is installed
  add_test(NAME consumer_installed_tools COMMAND "${CMAKE_COMMAND}" "-DPREFIX=${consumer_prefix}" "-DFILE=${consumer_v1}"
    "-DBIN=${CMAKE_INSTALL_BINDIR}" "-DDATA=${CMAKE_INSTALL_DATADIR}" -P "${consumer_source}/installed/check_tools.cmake")
  set_tests_properties(consumer_installed_tools PROPERTIES LABELS consumer
    FIXTURES_REQUIRED "consumer_prefix;consumer_v1")
endif()
add_test(NAME consumer_copy COMMAND "${CMAKE_COMMAND}" "-DSOURCE=${PROJECT_SOURCE_DIR}" "-DDESTINATION=${consumer_copy}"
  "-DTHIRD_PARTY=${OPENNTC_RAPIDJSON_INCLUDE_DIR}/rapidjson;${OPENNTC_EXPECTED_INCLUDE_DIR}/tl" "-DFOR_DECODE=${OPENNTC_GLM_INCLUDE_DIR}/glm"
  -P "${consumer_source}/prepare_copy.cmake")
set_tests_properties(consumer_copy PROPERTIES LABELS consumer FIXTURES_SETUP consumer_copy)

openntc_add_consumer(subdirectory subdirectory "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_v1}")
openntc_add_consumer(vendored vendored "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_v1}")
openntc_add_consumer(installed installed "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_v1}"
  OPTIONS "-DCMAKE_PREFIX_PATH=${consumer_prefix}" FIXTURE consumer_prefix)

# Packages for others' build systems, and all headers as one file.
set(packages_ntc "")
if(TARGET ntc)
  set(packages_ntc "-DNTC=$<TARGET_FILE:ntc>")
endif()
add_test(NAME consumer_packages COMMAND "${CMAKE_COMMAND}" "-DBUILD=${PROJECT_BINARY_DIR}" "-DDIRECTORY=${consumer_build}/packages" ${packages_ntc}
  "-DCOMPILER=${CMAKE_CXX_COMPILER}" "-DSOURCE=${consumer_source}" -P "${consumer_source}/packages/check.cmake")
add_test(NAME consumer_amalgamated COMMAND "${CMAKE_COMMAND}" "-DROOT=${PROJECT_SOURCE_DIR}" "-DCOMPILER=${CMAKE_CXX_COMPILER}"
  "-DDIRECTORY=${consumer_build}/amalgamated" "-DFILE=${consumer_v1}" "-DGLSLANG=${OPENNTC_GLSLANG_VALIDATOR}"
  "-DCOPY=${consumer_copy}"
  -P "${consumer_source}/amalgamated/check.cmake")
set_tests_properties(consumer_packages consumer_amalgamated PROPERTIES LABELS consumer TIMEOUT 300)
set_tests_properties(consumer_amalgamated PROPERTIES FIXTURES_REQUIRED "consumer_v1;consumer_copy")

# What README shows is compiled as it stands, and survives files that are missing or cut short.
openntc_add_consumer(readme readme "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_v1}" "${consumer_gen3}"
  OPTIONS "-DCMAKE_PREFIX_PATH=${consumer_prefix}" FIXTURE "consumer_prefix;consumer_gen3")
openntc_add_consumer(readme_fetched readme "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_v1}" "${consumer_gen3}" FIXTURE consumer_gen3 OPTIONS -DFETCHED=ON)
openntc_add_consumer(pages pages "${CMAKE_CXX_COMPILER}" ARGUMENTS "${consumer_build}/pages/app_shaders"
  OPTIONS "-DCMAKE_PREFIX_PATH=${consumer_prefix}" FIXTURE consumer_prefix)

# The installed package says which headers it lacks.
openntc_add_refusal(NAME consumer_missing_headers LABEL consumer
  REASON "OpenNTC lacks headers:.*rapidjson/reader.h.*tl/expected.hpp.*glm/vec4.hpp"
  COMMAND "${CMAKE_COMMAND}" --fresh -G "${CMAKE_GENERATOR}"
  -S "${consumer_source}/installed" -B "${consumer_build}/missing_headers" "-DCMAKE_CXX_COMPILER=${CMAKE_CXX_COMPILER}"
  "-Dopenntc_DIR=${consumer_prefix}/${CMAKE_INSTALL_DATADIR}/cmake/openntc"
  "-DCMAKE_FIND_ROOT_PATH=${consumer_build}/nowhere" -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY)
set_tests_properties(consumer_missing_headers PROPERTIES FIXTURES_REQUIRED consumer_prefix)

set(consumer_compilers "gcc|${CMAKE_CXX_COMPILER}")
if(OPENNTC_CLANG)
  list(APPEND consumer_compilers "clang|${OPENNTC_CLANG}")
endif()
foreach(entry ${consumer_compilers})
  string(REPLACE "|" ";" entry "${entry}")
  list(GET entry 0 family)
  list(GET entry 1 compiler)
  # One compiler is enough to find a missing include; the other one compiles all headers together. Only g++'s warnings
  # depend on the optimiser.
  if(family STREQUAL "gcc")
    set(alone ON)
    set(type Release)
  else()
    set(alone OFF)
    set(type None)
  endif()
  openntc_add_consumer(copied_${family} copied "${compiler}" ARGUMENTS "${consumer_v1}" FIXTURE consumer_copy TYPE ${type})
  openntc_add_consumer(headers_${family} headers "${compiler}" FIXTURE consumer_copy TYPE None
    OPTIONS -DHEADERS_ALONE=${alone})
  set_tests_properties(consumer_headers_${family} PROPERTIES COST 90)
  openntc_add_consumer(flags_${family} flags "${compiler}" TYPE Release
    OPTIONS "-DOPENNTC_USER_FLAGS=-O3 -march=native -ffp-contract=fast")
  openntc_add_refusal(NAME consumer_fast_math_${family} LABEL consumer REASON "error: [^\n]*fast-math[^\n]*"
    COMMAND "${compiler}" -std=c++20 -ffast-math -fsyntax-only "-I${PROJECT_SOURCE_DIR}/include"
      "-I${PROJECT_SOURCE_DIR}/shaders" "${consumer_source}/program/second.cpp")
  openntc_add_refusal(NAME consumer_cxx17_${family} LABEL consumer REASON "error: [^\n]*OpenNTC needs C[+][+]20"
    COMMAND "${compiler}" -std=c++17 -fsyntax-only "-I${PROJECT_SOURCE_DIR}/include" "-I${PROJECT_SOURCE_DIR}/shaders"
      "${consumer_source}/program/runtime.cpp")
  # The runtime alone takes that flag, and no GLM. With g++ the project `headers` compiles each of its headers that way.
  if(family STREQUAL "clang")
    add_test(NAME consumer_runtime_fast_math COMMAND "${CMAKE_COMMAND}" "-DCOMPILER=${compiler}" "-DCOPY=${consumer_copy}"
      "-DSOURCE=${consumer_source}/program/runtime.cpp" "-DPROGRAM=${consumer_build}/runtime_fast_math"
      -P "${consumer_source}/check_runtime.cmake")
    set_tests_properties(consumer_runtime_fast_math PROPERTIES LABELS consumer FIXTURES_REQUIRED consumer_copy)
  endif()
endforeach()

# Host programs whose headers define macros with our names, and which take no warnings: all headers, in both orders.
function(openntc_add_host name compiler header orders defines)
  string(REPLACE ";" "$<SEMICOLON>" defines "${defines}")
  string(REPLACE ";" "$<SEMICOLON>" orders "${orders}")
  add_test(NAME consumer_host_${name} COMMAND "${CMAKE_COMMAND}" "-DCOMPILER=${compiler}" "-DCOPY=${consumer_copy}"
    "-DSOURCE=${consumer_source}/hosts" "-DDIRECTORY=${consumer_build}/host_${name}" "-DHOST=${header}"
    "-DORDERS=${orders}" "-DDEFINES=${defines}" -P "${consumer_source}/hosts/check.cmake")
  set_tests_properties(consumer_host_${name} PROPERTIES LABELS consumer FIXTURES_REQUIRED consumer_copy TIMEOUT 600 COST 50)
endfunction()
set(host_macros "\"${consumer_source}/hosts/macros.h\"")
foreach(entry ${consumer_compilers})
  string(REPLACE "|" ";" entry "${entry}")
  list(GET entry 0 family)
  list(GET entry 1 compiler)
  openntc_add_host(macros_${family} "${compiler}" "${host_macros}" "first;second"
    "-DHOST_DEFINES_X11=1;-DHOST_DEFINES_FUNCTIONS=1")
endforeach()
openntc_add_host(x11 "${CMAKE_CXX_COMPILER}" "<X11/Xlib.h>" "first;second" "-DHOST_DEFINES_X11=1")
openntc_add_host(windows x86_64-w64-mingw32-g++-posix "<windows.h>" "first;second" "")

# The cache of compiled shaders. Without the validator: the test's marks are no SPIR-V.
add_test(NAME consumer_shader_cache COMMAND "${CMAKE_COMMAND}" "-DROOT=${PROJECT_SOURCE_DIR}"
  "-DGLSLANG=${OPENNTC_GLSLANG_VALIDATOR}" "-DDIRECTORY=${consumer_build}/shader_cache"
  -P "${consumer_source}/permutations/check_cache.cmake")
set_tests_properties(consumer_shader_cache PROPERTIES LABELS consumer)

# Shader permutations: blobs, lists, what is compiled again when a file changes, and the same bytes from `ntc`.
set(permutations_ntc "")
if(TARGET ntc AND TARGET openntc_shader_compiler)
  set(permutations_ntc "-DNTC=$<TARGET_FILE:ntc>")
endif()
add_test(NAME consumer_permutations COMMAND "${CMAKE_COMMAND}" "-DSOURCE=${consumer_source}/permutations"
  "-DDIRECTORY=${consumer_build}/permutations" "-DROOT=${PROJECT_SOURCE_DIR}" "-DGENERATOR=${CMAKE_GENERATOR}"
  "-DCXX=${CMAKE_CXX_COMPILER}" ${permutations_ntc} -P "${consumer_source}/permutations/check.cmake")
set_tests_properties(consumer_permutations PROPERTIES LABELS consumer TIMEOUT 300)

# Every block of code of the migration page is compiled and run. Kernels of encoder and decoder run for milliseconds there.
set_source_files_properties("${consumer_source}/migration/calls_test.cpp" "${consumer_source}/migration/encode_calls_test.cpp"
  PROPERTIES COMPILE_OPTIONS -O0)
openntc_add_test(NAME consumer_migration LABEL consumer DIRECTORY consumer/migration
  LIBRARIES openntc::encode openntc::decode)
openntc_add_shaders(TARGET consumer_migration HEADER_NAME migration_shaders.h
  SOURCES "${consumer_source}/migration/SampleMaterial.comp" NETWORK_VERSIONS SMALL LARGE MATH INT8)

include("${consumer_source}/python/tests.cmake")
include("${consumer_source}/webgl/tests.cmake")
