# SPDX-License-Identifier: MIT
# Script: compiles a permutation, checks it and, if OPENNTC_EMBED names a file, writes it there as the initialisers of a C++
# array. An error is the compiler's, behind what was compiled; of a failed #error only that line, because glslang goes on.
# cmake -DOPENNTC_SOURCE=a.comp -DOPENNTC_OUTPUT=a.spv -DOPENNTC_LABEL="a.comp X=1" -DOPENNTC_VALIDATOR=spirv-val
#   -DOPENNTC_ENVIRONMENT=vulkan1.1 -DOPENNTC_EMBED=a.spv.inc -P OpenNTCCompileShader.cmake -- glslangValidator OPTIONS…
# OPENNTC_STORED names a file that holds the SPIR-V already.
cmake_minimum_required(VERSION 3.25)
set(command "")
set(at 0)
while(NOT CMAKE_ARGV${at} STREQUAL "--")
  math(EXPR at "${at} + 1")
endwhile()
math(EXPR at "${at} + 1")
set(compiler "${CMAKE_ARGV${at}}")
foreach(i RANGE ${at} ${CMAKE_ARGC})
  if(i LESS CMAKE_ARGC)
    list(APPEND command "${CMAKE_ARGV${i}}")
  endif()
endforeach()

function(fail_on result output program)
  if(result EQUAL 0)
    return()
  endif()
  file(REMOVE "${OPENNTC_OUTPUT}")
  if(NOT result MATCHES "^[0-9]+$")
    set(output "${program} crashed (${result})")
  elseif(output MATCHES "([^\n]*: '#error' : [^\n]*)")
    string(REGEX REPLACE "^ERROR: " "" output "${CMAKE_MATCH_1}")
  endif()
  string(STRIP "${OPENNTC_LABEL}" label)
  string(STRIP "${output}" output)
  string(REPLACE "\n" "\n " output "${output}")
  # A space in front keeps CMake from breaking lines.
  message(FATAL_ERROR " ${label}: ${output}")
endfunction()

if(OPENNTC_STORED)
  file(COPY_FILE "${OPENNTC_STORED}" "${OPENNTC_OUTPUT}")
  file(WRITE "${OPENNTC_OUTPUT}.d" "${OPENNTC_OUTPUT}: ${OPENNTC_STORED}\n")
else()
  # GLSL includes files by an extension; a shader that does not ask for it is compiled from a copy that does. The copy's lines
  # have the original's name and numbers; the original's folder is the first to be searched for included files, as the last
  # that is named.
  set(source "${OPENNTC_SOURCE}")
  if(NOT source MATCHES "\\.hlsl$")
    file(READ "${source}" text)
    if(text MATCHES "#[ \t]*include" AND NOT text MATCHES "GL_GOOGLE_include_directive"
        AND text MATCHES "(^|\n)[ \t]*#[ \t]*version[^\n]*\n")
      string(FIND "${text}" "${CMAKE_MATCH_0}" begin)
      string(LENGTH "${CMAKE_MATCH_0}" length)
      math(EXPR end "${begin} + ${length}")
      string(SUBSTRING "${text}" 0 ${end} head)
      string(SUBSTRING "${text}" ${end} -1 tail)
      string(REGEX REPLACE "[^\n]" "" lines "${head}")
      string(LENGTH "${lines}" number)
      math(EXPR number "${number} + 1")
      cmake_path(GET source PARENT_PATH folder)
      list(APPEND command "-I${folder}")
      cmake_path(GET source EXTENSION LAST_ONLY ending)
      set(source "${OPENNTC_OUTPUT}.source${ending}")
      file(WRITE "${source}"
        "${head}#extension GL_GOOGLE_include_directive : require\n#line ${number} \"${OPENNTC_SOURCE}\"\n${tail}")
    endif()
  endif()

  execute_process(COMMAND ${command} --depfile "${OPENNTC_OUTPUT}.d" -o "${OPENNTC_OUTPUT}" "${source}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  fail_on("${result}" "${output}" "${compiler}")
  if(output MATCHES "[^ \n]")
    message(NOTICE "${output}")
  endif()
endif()
if(OPENNTC_VALIDATOR)
  execute_process(COMMAND "${OPENNTC_VALIDATOR}" --target-env "${OPENNTC_ENVIRONMENT}" "${OPENNTC_OUTPUT}"
    RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  fail_on("${result}" "${output}" "${OPENNTC_VALIDATOR}")
endif()
if(OPENNTC_EMBED)
  file(READ "${OPENNTC_OUTPUT}" bytes HEX)
  string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1,\n" words "${bytes}")
  file(WRITE "${OPENNTC_EMBED}" "${words}")
endif()
