# SPDX-License-Identifier: MIT
# Script: writes the index, "source|defines" lines, of what openntc_add_shaders() would compile.
# cmake -DMODULES=cmake -DOUTPUT=index.txt -DARGUMENTS="LIST;shaders.txt" -P list_shaders.cmake
cmake_minimum_required(VERSION 3.25)
include("${MODULES}/OpenNTCShaderPlan.cmake")
_openntc_plan_shaders(plan ${ARGUMENTS})
set(text "")
foreach(record IN LISTS plan)
  string(REGEX REPLACE "^[^\t]*\t([^\t]*)\t([^\t]*)\t.*$" "\\1|\\2\n" line "${record}")
  string(APPEND text "${line}")
endforeach()
file(WRITE "${OUTPUT}" "${text}")
