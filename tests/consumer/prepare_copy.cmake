# SPDX-License-Identifier: MIT
# cmake -DSOURCE=… -DDESTINATION=… -DTHIRD_PARTY="dir/rapidjson;…" -DFOR_DECODE="dir/glm" -P: the folder of a user who
# copies OpenNTC's files. Users without the decoders have no GLM; before it in the include path, no_glm/ plays that.
file(REMOVE_RECURSE "${DESTINATION}")
file(COPY "${SOURCE}/include" "${SOURCE}/shaders" DESTINATION "${DESTINATION}")
file(MAKE_DIRECTORY "${DESTINATION}/third_party")
foreach(folder ${THIRD_PARTY})
  cmake_path(GET folder FILENAME name)
  file(CREATE_LINK "${folder}" "${DESTINATION}/third_party/${name}" SYMBOLIC COPY_ON_ERROR)
endforeach()
file(MAKE_DIRECTORY "${DESTINATION}/for_decode")
foreach(folder ${FOR_DECODE})
  cmake_path(GET folder FILENAME name)
  file(CREATE_LINK "${folder}" "${DESTINATION}/for_decode/${name}" SYMBOLIC COPY_ON_ERROR)
  file(GLOB headers RELATIVE "${folder}" "${folder}/*.hpp")
  foreach(header ${headers})
    file(WRITE "${DESTINATION}/no_glm/${name}/${header}" "#error the runtime does without ${name}\n")
  endforeach()
endforeach()
