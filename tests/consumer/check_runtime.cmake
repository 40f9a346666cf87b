# SPDX-License-Identifier: MIT
# cmake -DCOMPILER=… -DCOPY=… -DSOURCE=… -DPROGRAM=… -P: compiles without GLM and with -ffast-math, and runs.
execute_process(COMMAND "${COMPILER}" -std=c++20 -O1 -ffast-math -Wall -Wextra -Wpedantic
    "-I${COPY}/no_glm" "-I${COPY}/include" "-I${COPY}/shaders" "-isystem${COPY}/third_party" "${SOURCE}" -o "${PROGRAM}"
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${PROGRAM}" COMMAND_ERROR_IS_FATAL ANY)
