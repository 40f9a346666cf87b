# SPDX-License-Identifier: MIT
# cmake -DBUILD=… -DSOURCE=… -DNODE=… -DNPM=… -DNTC=… -DDIRECTORY=… -DSETS=… -P: the module that consumer_webgl has built, in Dawn of npm's
# package webgpu: that of stage compilers, or one that is installed here.
if(NOT EXISTS "${BUILD}/webgl/openntc-webgpu.js")
  message("SKIP: consumer_webgpu_dawn: openntc-webgpu.js is not built")
  return()
endif()
file(GLOB packages "${BUILD}/../compilers/node_modules/webgpu" "${DIRECTORY}/node_modules/webgpu")
if(NOT packages)
  file(MAKE_DIRECTORY "${DIRECTORY}")
  execute_process(COMMAND "${NPM}" install --no-audit --no-fund --ignore-scripts --loglevel=error --prefix "${DIRECTORY}" webgpu@0.6.2
    RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    string(REGEX MATCH "E[A-Z_]+" reason "${output}")
    message("SKIP: consumer_webgpu_dawn: webgpu cannot be had from npm: ${reason}")
    return()
  endif()
  set(packages "${DIRECTORY}/node_modules/webgpu")
endif()
list(GET packages 0 package)
set(ENV{EGL_PLATFORM} surfaceless)
execute_process(COMMAND "${NODE}" "${SOURCE}/dawn_test.mjs" "${BUILD}/webgl/openntc-webgpu.js" "${package}" "${NTC}" ${SETS}
  COMMAND_ERROR_IS_FATAL ANY)
