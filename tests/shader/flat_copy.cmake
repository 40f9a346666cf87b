# SPDX-License-Identifier: MIT
# The shader headers copied flat into one folder, as they are and as *.ush with the ending in their includes changed (what
# engines with their own include resolution do), still compile; and so does every order of including them.
#   cmake -DSHADERS=<shaders/openntc> -DWORK=<folder> -DVALIDATOR=<glslangValidator> -P flat_copy.cmake
file(REMOVE_RECURSE "${WORK}")
file(GLOB headers "${SHADERS}/*.h" "${SHADERS}/passes/*.h" "${SHADERS}/streaming/*.h" "${SHADERS}/bc/*.h"
  "${SHADERS}/filtering/*.h")
file(GLOB passes "${SHADERS}/passes/*.comp" "${SHADERS}/passes/*.hlsl")
list(FILTER passes EXCLUDE REGEX "/ProbeCoopMat\\.comp$") # an extension that not every compiler has
if(NOT headers OR NOT passes)
  message(FATAL_ERROR "no shader headers in ${SHADERS}")
endif()

set(compiled 0)
function(compile file)
  set(language)
  if(file MATCHES "\\.hlsl$")
    set(language -D -S comp -e main -DNTC_HLSL=1)
  endif()
  execute_process(COMMAND "${VALIDATOR}" ${language} --quiet -V --target-env vulkan1.1 -DNETWORK_VERSION=1 -DNTC_MATH=1 -DNTC_BC_FORMAT=3
    -DNTC_COOPMAT_EMULATED=1
    ${ARGN} -o "${file}.spv" "${file}" RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${file} does not compile:\n${output}")
  endif()
  math(EXPR count "${compiled} + 1")
  set(compiled ${count} PARENT_SCOPE)
endfunction()

# In the passes and the headers of streaming/, bc/ and filtering/ the folders go; nothing else of them is changed.
foreach(ending h ush)
  set(folder "${WORK}/${ending}")
  foreach(file IN LISTS headers passes)
    file(READ "${file}" text)
    string(REPLACE "#include \"openntc/" "#include \"" text "${text}")
    string(REGEX REPLACE "#include \"(streaming|bc|passes|filtering)/" "#include \"" text "${text}")
    string(REGEX REPLACE "(#include \"[A-Za-z0-9]+)\\.h\"" "\\1.${ending}\"" text "${text}")
    get_filename_component(name "${file}" NAME)
    string(REGEX REPLACE "\\.h$" ".${ending}" name "${name}")
    file(WRITE "${folder}/${name}" "${text}")
  endforeach()
  foreach(pass IN LISTS passes)
    get_filename_component(name "${pass}" NAME)
    compile("${folder}/${name}")
  endforeach()
endforeach()

# Each header first, all in alphabetical order, and all backwards. PortabilityCpp.h is C++; InferenceCoopVec.h is
# Inference.h's to include: it needs an extension that not every compiler has. NetworkCoopMat.h is for one pass, which says
# where its weights are.
set(names)
foreach(header IN LISTS headers)
  get_filename_component(name "${header}" NAME)
  if(NOT name MATCHES "^(InferenceCoopVec|NetworkCoopMat|NetworkCoopMatTypes|PortabilityCpp)\\.h$")
    list(APPEND names "${name}")
  endif()
endforeach()
set(backwards ${names})
list(REVERSE backwards)
set(orders "alphabetical" "backwards")
set(order_alphabetical ${names})
set(order_backwards ${backwards})
foreach(name IN LISTS names)
  list(APPEND orders "${name}")
  set(order_${name} "${name}" "Inference.h")
endforeach()
foreach(order IN LISTS orders)
  foreach(pass IN LISTS passes)
    set(includes)
    foreach(name IN LISTS order_${order})
      string(APPEND includes "#include \"${name}\"\n")
    endforeach()
    file(READ "${pass}" text)
    if(NOT text MATCHES "openntc/Inference.h") # decodes nothing
      continue()
    endif()
    # Of one mip, where the headers of tiles are of several; or with buffers of its own.
    if(text MATCHES "define (NTC_SINGLE_MIP 1|NtcBufferLoad)")
      continue()
    endif()
    # Which header is first matters in one language as in the other; the two orders of all are tried in both.
    if(pass MATCHES "\\.hlsl$" AND NOT order MATCHES "^(alphabetical|backwards)$")
      continue()
    endif()
    string(REPLACE "#include \"openntc/Inference.h\"\n" "${includes}" text "${text}")
    get_filename_component(name "${pass}" NAME)
    file(WRITE "${WORK}/h/${order}-${name}" "${text}")
    compile("${WORK}/h/${order}-${name}")
  endforeach()
endforeach()
message(STATUS "shaders compiled: ${compiled}")
