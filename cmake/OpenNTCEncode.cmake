# SPDX-License-Identifier: MIT
# The CPU encoder: header-only like the rest; trains with threads.
include_guard(GLOBAL)

add_library(openntc_encode INTERFACE)
add_library(openntc::encode ALIAS openntc_encode)
set_target_properties(openntc_encode PROPERTIES EXPORT_NAME encode)
target_link_libraries(openntc_encode INTERFACE openntc Threads::Threads)
