# SPDX-License-Identifier: MIT
# cmake -DPREFIX=… -DFILE=a.ntc -DBIN=bin -DDATA=share -P: what `cmake --install` puts beside the headers is there and runs.
execute_process(COMMAND "${PREFIX}/${BIN}/ntc" info --json "${FILE}" OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
file(READ "${PREFIX}/${DATA}/openntc/schemas/info.schema.json" schema)
string(JSON count LENGTH "${schema}" definitions set required)
math(EXPR last "${count} - 1")
foreach(i RANGE ${last})
  string(JSON key GET "${schema}" definitions set required ${i})
  string(JSON value GET "${text}" "${key}") # fails when `ntc info` does not print it
endforeach()
foreach(file shaders/openntc/Inference.h examples/ntc/report/ReportDecode.comp LICENSE)
  if(NOT EXISTS "${PREFIX}/${DATA}/openntc/${file}")
    message(FATAL_ERROR "not installed: ${DATA}/openntc/${file}")
  endif()
endforeach()
