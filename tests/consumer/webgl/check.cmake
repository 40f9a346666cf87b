# SPDX-License-Identifier: MIT
# cmake -DBUILD=… -DSOURCE=… -DNODE=… -DNTC=… -DSYNTHESIZE=… -DCHROMIUM=… -DXVFB=… -DDIRECTORY=… -DPAGES=docs/engines -DSETS=… -P: builds
# the viewer and the modules, which takes three.js from npm, and runs them in Chromium with SETS, of which it makes those
# of the largest network and of generations 2 and 3.
execute_process(COMMAND "${CMAKE_COMMAND}" --build "${BUILD}" --target webgl_viewer RESULT_VARIABLE result OUTPUT_VARIABLE output
  ERROR_VARIABLE output)
if(NOT result EQUAL 0 AND output MATCHES "npm error (code|network)? ?(E[A-Z_]+)" AND NOT CMAKE_MATCH_2 STREQUAL "EUSAGE")
  message("SKIP: consumer_webgl: three.js and esbuild cannot be had from npm: ${CMAKE_MATCH_2}")
  return()
elseif(NOT result EQUAL 0)
  message(FATAL_ERROR "${output}")
endif()
file(MAKE_DIRECTORY "${DIRECTORY}")
foreach(name xlarge gen2)
  execute_process(COMMAND "${SYNTHESIZE}" ${name} "${DIRECTORY}/${name}.ntc" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
# A set of generation 3, whose quality does not matter.
list(GET SETS 1 small)
execute_process(COMMAND "${NTC}" migrate "${small}" --generation 3 --steps 16 --quiet -o "${DIRECTORY}/gen3.ntc" COMMAND_ERROR_IS_FATAL ANY)
set(driver swiftshader)
if(XVFB)
  set(driver llvmpipe)
endif()
execute_process(COMMAND "${NODE}" "${SOURCE}/page_test.mjs" "${BUILD}/webgl/viewer.html" "${PAGES}/webgl.md" "${NTC}" "${CHROMIUM}" "${driver}"
  "${DIRECTORY}" ${SETS} COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${NODE}" "${SOURCE}/../webgpu/webgpu_test.mjs" "${BUILD}/webgl/openntc-webgpu.js" "${PAGES}/webgpu.md"
  "${NTC}" "${CHROMIUM}" ${SETS} COMMAND_ERROR_IS_FATAL ANY)
