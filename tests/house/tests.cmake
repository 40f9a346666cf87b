# SPDX-License-Identifier: MIT
# The contracts of docs/architecture.md, read from the sources themselves.
openntc_add_test(NAME house LABEL house DIRECTORY house
  DEFINITIONS "OPENNTC_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\"")
