# SPDX-License-Identifier: MIT
# cmake -DNTC=ntc -DDIRECTORY=… -P: the manual page of the command line, and completions for shells.
file(MAKE_DIRECTORY "${DIRECTORY}")
execute_process(COMMAND "${NTC}" help --man OUTPUT_FILE "${DIRECTORY}/ntc.1" COMMAND_ERROR_IS_FATAL ANY)
foreach(pair bash/ntc.bash zsh/_ntc fish/ntc.fish)
  cmake_path(GET pair PARENT_PATH shell)
  cmake_path(GET pair FILENAME file)
  execute_process(COMMAND "${NTC}" help --completion "${shell}" OUTPUT_FILE "${DIRECTORY}/${file}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
