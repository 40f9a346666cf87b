# SPDX-License-Identifier: MIT
# Emulators are 20 times slower than the machine: there the decoders run the specification's vectors and the checksums, and
# the encoder its formulas; everything is compiled.
set(decode_arguments "")
set(encode_arguments "")
if(CMAKE_CROSSCOMPILING)
  set(decode_arguments "-tc=V1*,V2*,fast decoder: V*,checksums*")
  set(encode_arguments "-sf=*blended_test.cpp,*eight_bits_test.cpp,*geometry_test.cpp,*kernels_test.cpp,*mip_generation_test.cpp")
  openntc_say_skipped(unit unit_decode_left_out "unit_decode: all but vectors and checksums: too slow in an emulator")
  openntc_say_skipped(unit unit_encode_left_out "unit_encode: all that trains for more than three steps: too slow in an emulator")
  openntc_leave_out(unit streaming_arguments NAME unit_streaming WHY "too slow in an emulator"
    CASES "tile manager: random operations*" "demand case 45*" "demand case 46*" "demand: samples of every kind*"
      "feedback C1? C2? C6*" "feedback C3*" "feedback C8*")
  openntc_leave_out(unit bc_arguments NAME unit_bc WHY "too slow in an emulator"
    CASES "BC4: close to the optimum*" "BC6H: solid*" "BC6H: lanes*" "BC6H: higher*" "BC6H: blocks of the ends*" "bc7: lanes*"
      "bc7: no block*" "bc7: a hint*" "block decoder: BC4's and BC5's palettes*")
  openntc_leave_out(unit filtering_arguments NAME unit_filtering WHY "too slow in an emulator"
    CASES "filtering: hashed*" "filtering: means*" "waves: collaboration*" "waves: partial*")
endif()
set(test_definitions "")
if(OPENNTC_SANITIZE)
  set(test_definitions OPENNTC_TEST_SANITIZED)
endif()
set(topics core container texture_set inference permutation streaming decode opaque encode bc passes filtering)
# Sanitizers slow training down ten times. What remains trains with every kernel, with threads, and is cancelled and resumed.
if(OPENNTC_SANITIZE)
  openntc_leave_out(unit encode_arguments NAME unit_encode WHY "trains for minutes under sanitizers"
    CASES "the decoded file has the PSNR*" "training that diverges*" "hard materials*" "the portable kernel's bytes*"
      "a kept move lowers*" "the search finds*" "a limit of bits per pixel*" "the FP8 network decodes*" "a mask's exact*"
      "a material given away*" "a cancelled run resumes*" "effort: a flat curve ends*")
  openntc_leave_out(unit bc_arguments NAME unit_bc WHY "takes long under sanitizers"
    CASES "BC4: close to the optimum*" "BC6H: solid*" "BC6H: higher*" "BC6H: blocks of the ends*" "bc7: no block*")
endif()
if(OPENNTC_SANITIZE)
  openntc_leave_out(unit filtering_arguments NAME unit_filtering WHY "takes long under sanitizers"
    CASES "filtering: hashed*" "filtering: means*" "waves: collaboration*")
endif()
# Clang's release build is for the arithmetic of its optimiser, of which these trainings show no more than the others.
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND NOT OPENNTC_SANITIZE AND CMAKE_BUILD_TYPE STREQUAL "Release")
  openntc_leave_out(unit encode_arguments NAME unit_encode WHY "stage release trains that long, with g++"
    CASES "the FP8 network decodes*" "a mask's exact*" "training that diverges*" "a cancelled run resumes*"
      "a run cancelled during*" "effort: a flat curve ends*")
endif()
# ThreadSanitizer has something to find where there are threads.
if(OPENNTC_SANITIZE STREQUAL "thread")
  openntc_leave_out(unit streaming_arguments NAME unit_streaming WHY "has no threads, and ThreadSanitizer slows it down"
    CASES "tile manager*" "tile layout*" "page table*" "feedback*")
  set(decode_arguments "-tc=fast decoder: results do not depend*,fast decoder: one decoder used*,demand*,V1*,V2*")
  openntc_say_skipped(unit unit_decode_left_out "unit_decode: cases without threads: ThreadSanitizer slows them down")
  set(topics core streaming decode encode)
  openntc_say_skipped(unit unit_left_out "unit: topics whose code has no threads: stage asan runs them")
endif()
foreach(topic ${topics})
  if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/unit/${topic}")
    if(topic STREQUAL "decode")
      set(libraries openntc::decode openntc_models)
    elseif(topic STREQUAL "encode")
      set(libraries openntc_training openntc::encode openntc::decode)
    elseif(topic STREQUAL "filtering")
      set(libraries openntc::decode openntc_models) # emulated waves are the examples'
    elseif(topic MATCHES "^(opaque|passes)$")
      set(libraries openntc::decode)
    elseif(topic MATCHES "^(streaming|bc)$")
      set(libraries openntc::decode Threads::Threads)
    elseif(topic STREQUAL "core")
      set(libraries openntc::openntc Threads::Threads)
    else()
      set(libraries openntc::openntc)
    endif()
    set(temperature "")
    set(seconds 1)
    if(topic STREQUAL "encode")
      set(seconds 60)
    endif()
    if(topic MATCHES "^(decode|encode|opaque|bc)$")
      set(temperature HOT)
    elseif(topic MATCHES "^(streaming|filtering)$" OR (topic STREQUAL "container" AND NOT OPENNTC_SANITIZE))
      set(temperature WARM) # GDeflate's encoder runs for seconds; of sanitizers, every check
    endif()
    set(definitions ${test_definitions})
    if(NOT temperature STREQUAL "HOT")
      # A check is a call in the place of a block with an exception handler: up to a quarter less to compile where there are many.
      list(APPEND definitions DOCTEST_CONFIG_SUPER_FAST_ASSERTS)
    endif()
    openntc_add_test(NAME unit_${topic} SECONDS ${seconds} LABEL unit DIRECTORY unit/${topic} LIBRARIES ${libraries}
      ARGUMENTS ${${topic}_arguments} ${temperature} DEFINITIONS ${definitions})
  endif()
endforeach()

if(NOT CMAKE_CROSSCOMPILING)
  # A locale with a decimal comma, for the tests of numbers.
  if(TEST unit_container)
    find_program(OPENNTC_LOCALEDEF localedef)
    if(OPENNTC_LOCALEDEF)
      set(locales "${CMAKE_CURRENT_BINARY_DIR}/locales")
      file(MAKE_DIRECTORY "${locales}")
      execute_process(COMMAND "${OPENNTC_LOCALEDEF}" -i de_DE -f UTF-8 "${locales}/de_DE.UTF-8" OUTPUT_QUIET ERROR_QUIET)
      set_tests_properties(unit_container PROPERTIES ENVIRONMENT "LOCPATH=${locales}")
    endif()
  endif()
endif()

# What the renderer has that needs no device.
if(TARGET openntc_renderer_scene AND NOT OPENNTC_SANITIZE STREQUAL "thread")
  set(renderer_temperature "")
  if(NOT OPENNTC_SANITIZE) # what takes time there is in the library
    set(renderer_temperature WARM)
  endif()
  openntc_add_test(${renderer_temperature} NAME unit_renderer LABEL unit DIRECTORY unit/renderer LIBRARIES openntc_renderer_scene)
  set(renderer_tests unit_renderer)
  find_program(OPENNTC_GLSLANG_VALIDATOR glslangValidator)
  if(OPENNTC_GLSLANG_VALIDATOR)
    set(includes "-I${PROJECT_SOURCE_DIR}/examples" "-I${OPENNTC_SHADER_DIR}")
    add_test(NAME unit_renderer_glsl COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" --target-env vulkan1.2 ${includes}
      -o "${CMAKE_CURRENT_BINARY_DIR}/renderer_glsl.spv" "${CMAKE_CURRENT_SOURCE_DIR}/unit/renderer/Shading.comp")
    add_test(NAME unit_renderer_hlsl COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" -D -DNTC_HLSL=1 -S comp -e main
      --target-env vulkan1.1 ${includes} -o "${CMAKE_CURRENT_BINARY_DIR}/renderer_hlsl.spv"
      "${CMAKE_CURRENT_SOURCE_DIR}/unit/renderer/Shading.hlsl")
    list(APPEND renderer_tests unit_renderer_glsl unit_renderer_hlsl)
  endif()
  set_tests_properties(${renderer_tests} PROPERTIES LABELS "unit;renderer")
endif()
