# SPDX-License-Identifier: MIT
# Writes HEADER with the commit of SOURCE, for `ntc --version`; run at every build, and leaves a header that is right
# alone, so that nothing is compiled again. COMMIT, if not empty, is taken as it is (packages are built without git).
if(COMMIT STREQUAL "")
  set(COMMIT "unknown")
  find_package(Git QUIET)
  # A folder inside another repository would give that one's commit.
  if(Git_FOUND AND EXISTS "${SOURCE}/.git")
    execute_process(COMMAND "${GIT_EXECUTABLE}" describe --always --dirty=+changes --abbrev=12 --exclude=*
      WORKING_DIRECTORY "${SOURCE}" OUTPUT_VARIABLE described RESULT_VARIABLE result ERROR_QUIET
      OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(result EQUAL 0)
      set(COMMIT "${described}")
    endif()
  endif()
endif()
set(text "// Made by OpenNTCCommit.cmake.\n#pragma once\n#define OPENNTC_COMMIT \"${COMMIT}\"\n")
set(old "")
if(EXISTS "${HEADER}")
  file(READ "${HEADER}" old)
endif()
if(NOT old STREQUAL text)
  file(WRITE "${HEADER}" "${text}")
endif()
