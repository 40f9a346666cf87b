# SPDX-License-Identifier: MIT
# Script: a permutation as one text without directives but #version, #extension (both at the top, where WebGL wants them) and
# #pragma. examples/shader_compiler/Flatten.cpp is the same for `ntc compile-shaders --flatten`.
# cmake -DOPENNTC_SOURCE=a.comp -DOPENNTC_OUTPUT=a.glsl -DOPENNTC_LABEL="a.comp X=1" -P OpenNTCFlattenShader.cmake
#   -- glslangValidator -E OPTIONS…
cmake_minimum_required(VERSION 3.25)
include("${CMAKE_CURRENT_LIST_DIR}/OpenNTCShaderCommand.cmake")
openntc_read_shader_command()
# Text of functions alone has no #version; it is preprocessed as desktop GLSL.
openntc_ask_for_includes("#version 460\n")
if(source STREQUAL OPENNTC_SOURCE)
  file(READ "${source}" text)
endif()
set(has_version FALSE)
if(text MATCHES "(^|\n)[ \t]*#[ \t]*version")
  set(has_version TRUE)
endif()
execute_process(COMMAND ${command} "${source}" RESULT_VARIABLE result OUTPUT_VARIABLE flat ERROR_VARIABLE errors)
openntc_fail_on("${result}" "${errors}" "${compiler}")

# glslangValidator -E has no dependencies to write, but its lines say where they are from.
string(REGEX MATCHALL "#line [0-9]+ \"[^\"\n]*\"" files "${flat}")
list(TRANSFORM files REPLACE "^#line [0-9]+ \"(.*)\"$" "\\1")
list(APPEND files "${OPENNTC_SOURCE}")
list(REMOVE_DUPLICATES files)
list(TRANSFORM files REPLACE " " "\\\\ ")
list(JOIN files " " files)
file(WRITE "${OPENNTC_OUTPUT}.d" "${OPENNTC_OUTPUT}: ${files}\n")

string(REGEX REPLACE "[ \t\r]*\n[ \t\r\n]*" "\n" flat "\n${flat}\n") # no empty lines, no indentation
string(REGEX REPLACE "\n#line[^\n]*" "" flat "${flat}")
set(head "")
if(flat MATCHES "\n(#version[^\n]*\n)" AND has_version)
  set(head "${CMAKE_MATCH_1}")
endif()
string(REGEX REPLACE "\n#version[^\n]*" "" flat "${flat}")
string(REGEX REPLACE "\n#extension GL_GOOGLE_include_directive[^\n]*" "" flat "${flat}")
string(REGEX MATCHALL "\n#extension[^\n]*" extensions "${flat}")
list(REMOVE_DUPLICATES extensions)
foreach(extension IN LISTS extensions)
  string(SUBSTRING "${extension}" 1 -1 extension)
  string(APPEND head "${extension}\n")
endforeach()
string(REGEX REPLACE "\n#extension[^\n]*" "" flat "${flat}")
string(STRIP "${OPENNTC_LABEL}" label)
string(SUBSTRING "${flat}" 1 -1 flat)
file(WRITE "${OPENNTC_OUTPUT}" "${head}// ${label}, flattened; OpenNTC's functions in it: MIT license\n${flat}")
