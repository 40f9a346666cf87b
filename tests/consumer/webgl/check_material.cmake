# SPDX-License-Identifier: MIT
# cmake -DBUILD=… -DSOURCE=… -DNODE=… -DNTC=… -DCHROMIUM=… -DXVFB=… -DDIRECTORY=… -DSET=… -P: what the page and the module that
# consumer_webgl has built show, texel for texel.
if(NOT EXISTS "${BUILD}/webgl/viewer.html")
  message("SKIP: consumer_webgl_material: viewer.html is not built")
  return()
elseif(NOT XVFB)
  message("SKIP: consumer_webgl_material: no Xvfb, and minutes on SwiftShader")
  return()
endif()
file(MAKE_DIRECTORY "${DIRECTORY}")
execute_process(COMMAND "${NODE}" "${SOURCE}/material_test.mjs" "${BUILD}/webgl/viewer.html" "${BUILD}/examples/webgl" "${NTC}"
  "${CHROMIUM}" "${DIRECTORY}" "${SET}" COMMAND_ERROR_IS_FATAL ANY)
