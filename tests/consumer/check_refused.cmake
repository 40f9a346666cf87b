# SPDX-License-Identifier: MIT
# cmake -DCOMPILER=… -DARGUMENTS=… -DREASON=regex -P: passes if the compiler refuses, and says why.
separate_arguments(arguments UNIX_COMMAND "${ARGUMENTS}")
execute_process(COMMAND "${COMPILER}" ${arguments} RESULT_VARIABLE result OUTPUT_VARIABLE text ERROR_VARIABLE text)
if(result EQUAL 0)
  message(FATAL_ERROR "compiled, but must be refused: ${COMPILER} ${ARGUMENTS}")
endif()
string(REGEX MATCH "error: [^\n]*" reason "${text}")
if(NOT reason MATCHES "${REASON}")
  message(FATAL_ERROR "refused without the reason \"${REASON}\": ${text}")
endif()
message(STATUS "refused: ${reason}")
