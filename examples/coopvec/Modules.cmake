# SPDX-License-Identifier: MIT
# Sets OPENNTC_COOPVEC_MODULES to the permutations whose SPIR-V is kept here: "path below the repository's root|defines".
include("${CMAKE_CURRENT_LIST_DIR}/../../cmake/OpenNTCShaderPlan.cmake")
set(OPENNTC_COOPVEC_MODULES "")
cmake_path(SET openntc_root NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../..")
foreach(list report bench)
  _openntc_plan_shaders(records LIST "${CMAKE_CURRENT_LIST_DIR}/${list}.txt")
  foreach(record IN LISTS records)
    string(REPLACE "\t" ";" record "${record}")
    list(GET record 2 defines)
    list(GET record 4 path)
    cmake_path(RELATIVE_PATH path BASE_DIRECTORY "${openntc_root}")
    list(APPEND OPENNTC_COOPVEC_MODULES "${path}|${defines}")
  endforeach()
endforeach()

# The name of a module's file.
function(openntc_get_module_file out path defines)
  cmake_path(GET path FILENAME name)
  string(REPLACE " " "+" defines "${defines}")
  set(${out} "${name}+${defines}.spv" PARENT_SCOPE)
endfunction()
