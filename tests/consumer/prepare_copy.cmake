# SPDX-License-Identifier: MIT
# cmake -DSOURCE=… -DDESTINATION=… -DTHIRD_PARTY="dir/rapidjson;…" -P: the folder of a user who copies OpenNTC's files.
file(REMOVE_RECURSE "${DESTINATION}")
file(COPY "${SOURCE}/include" "${SOURCE}/shaders" DESTINATION "${DESTINATION}")
file(MAKE_DIRECTORY "${DESTINATION}/third_party")
foreach(folder ${THIRD_PARTY})
  cmake_path(GET folder FILENAME name)
  file(CREATE_LINK "${folder}" "${DESTINATION}/third_party/${name}" SYMBOLIC COPY_ON_ERROR)
endforeach()
