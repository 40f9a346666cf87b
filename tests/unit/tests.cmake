# SPDX-License-Identifier: MIT
# Emulators are 20 times slower than the machine: there the decoders run the specification's vectors, and the encoder its
# formulas; everything is compiled.
set(decode_arguments "")
set(encode_arguments "")
if(CMAKE_CROSSCOMPILING)
  set(decode_arguments "-sf=*specification_test.cpp")
  set(encode_arguments "-sf=*geometry_test.cpp,*mip_generation_test.cpp")
endif()
foreach(topic core container texture_set inference decode encode migration)
  if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/unit/${topic}")
    if(topic STREQUAL "decode")
      set(libraries openntc::decode)
    elseif(topic MATCHES "^(encode|migration)$")
      set(libraries openntc::encode openntc::decode)
    else()
      set(libraries openntc::openntc)
    endif()
    set(temperature "")
    if(topic MATCHES "^(decode|encode)$")
      set(temperature HOT)
    endif()
    openntc_add_test(NAME unit_${topic} LABEL unit DIRECTORY unit/${topic} LIBRARIES ${libraries}
      ARGUMENTS ${${topic}_arguments} ${temperature})
  endif()
endforeach()
# The page's shader calls are compiled too.
openntc_add_shaders(TARGET unit_migration HEADER_NAME migration_shaders.h
  SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/unit/migration/SampleMaterial.comp" NETWORK_VERSIONS SMALL LARGE MATH INT8)
