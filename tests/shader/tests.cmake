# SPDX-License-Identifier: MIT
# Shader tests dispatch on lavapipe (or the device named by OPENNTC_TEST_DEVICE) with the validation layer on.
if(NOT TARGET openntc_vulkan_harness AND NOT OPENNTC_BUILD_EXAMPLES)
  add_subdirectory("${PROJECT_SOURCE_DIR}/examples/vulkan_harness" "${PROJECT_BINARY_DIR}/examples/vulkan_harness")
endif()
if(TARGET openntc_vulkan_harness)
  # Many pipelines for few texels: without LLVM's optimisations lavapipe is through in three quarters of the time
  # (GALLIVM_PERF=nopt), and where nothing needs subgroups of eight, with vectors of four lanes in two thirds of that. The other tests
  # run with them.
  set(four_lanes GALLIVM_PERF=nopt LP_NATIVE_VECTOR_WIDTH=128)

  # The maths modes decode 100 000 texels each; as a test of their own they run beside the others.
  openntc_add_test(WARM NAME shader LABEL shader DIRECTORY shader ARGUMENTS "-tce=every maths mode*"
    LIBRARIES openntc::decode openntc_vulkan_harness)
  # Vectors of floats, which -O1 does not make.
  if(NOT MSVC)
    set_source_files_properties("${CMAKE_CURRENT_SOURCE_DIR}/shader/WideDecoder.cpp" PROPERTIES COMPILE_OPTIONS -O3)
  endif()
  set_source_files_properties("${CMAKE_CURRENT_SOURCE_DIR}/shader/WideDecoder.cpp" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  add_test(NAME shader_modes COMMAND shader "-tc=every maths mode*")
  set_tests_properties(shader_modes PROPERTIES LABELS shader TIMEOUT 1200 COST 85)
  openntc_add_shaders(TARGET shader HEADER_NAME harness_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/Fill.comp" DEFINES FACTOR={3,5} OFFSET)
  openntc_add_shaders(TARGET shader HEADER_NAME function_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/Functions.comp"
    NETWORK_VERSIONS LARGE MATH INT8 DEFINES NTC_DOT4_SPIRV={,1})
  openntc_add_shaders(TARGET shader HEADER_NAME hlsl_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/DecodeTexels.hlsl"
    NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE GEN2 GEN3 MATH INT8 INT8_HALF FP8 FP16 FP32
    STAGE comp)
  openntc_add_shaders(TARGET shader HEADER_NAME native_half_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/DecodeTexels.comp"
    NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE MATH FP16 DEFINES NTC_NATIVE_FLOAT16)
  # The layout test reads the permutations of the harness too.
  target_include_directories(shader PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader"
    $<TARGET_PROPERTY:openntc_vulkan_harness,INCLUDE_DIRECTORIES>)

  # The effect switches, in an executable of their own.
  openntc_add_test(WARM NAME shader_effects LABEL shader DIRECTORY shader/effects
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_effects PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set(effect_texels "${CMAKE_CURRENT_SOURCE_DIR}/shader/effects/EffectTexels.comp")
  openntc_add_shaders(TARGET shader_effects HEADER_NAME effect_masks.h SOURCES "${effect_texels}"
    NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE MATH INT8
    DEFINES NTC_OUTPUT_MASK={0x1,0x7,0x1FF,} NTC_LINEARISE=0 NTC_SINGLE_MIP NTC_LATENT_SLICES=0)
  openntc_add_shaders(TARGET shader_effects HEADER_NAME effect_linear.h SOURCES "${effect_texels}"
    NETWORK_VERSIONS SMALL MATH INT8
    DEFINES NTC_OUTPUT_MASK={0x1,0x7,0x1FF,0x8421,} NTC_LINEARISE={,2} NTC_CHANNEL_COLOR_SPACES=0x80040021)
  openntc_add_shaders(TARGET shader_effects HEADER_NAME effect_maths.h SOURCES "${effect_texels}"
    NETWORK_VERSIONS SMALL MATH INT8_HALF FP8 FP16 FP32
    DEFINES NTC_OUTPUT_MASK=0x8421 NTC_LINEARISE=0 NTC_SINGLE_MIP NTC_LATENT_SLICES=0)
  openntc_add_shaders(TARGET shader_effects HEADER_NAME effect_switches.h SOURCES "${effect_texels}"
    NETWORK_VERSIONS LARGE MATH INT8
    DEFINES NTC_SINGLE_MIP={,1} NTC_LATENT_SLICES={,0} NTC_CLAMP_TEXELS={,0})

  # Latents of generations 2 and 3 in a texture, in an executable of their own. HLSL has a combined image sampler in no form
  # that glslang 12 knows: it is compiled and validated only.
  openntc_add_test(WARM NAME shader_latents LABEL shader DIRECTORY shader/latents
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_latents PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_latents PROPERTIES ENVIRONMENT "${four_lanes}")
  openntc_add_shaders(TARGET shader_latents HEADER_NAME latent_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/latents/LatentTexels.comp"
    NETWORK_VERSIONS GEN2 GEN3 MATH INT8 FP8 FP16 FP32 DEFINES NTC_LATENT_FETCH=2)
  openntc_add_shaders(TARGET shader_latents HEADER_NAME latent_hlsl.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/latents/LatentTexels.comp.hlsl"
    NETWORK_VERSIONS GEN2 GEN3 MATH INT8 FP8 FP16 FP32 DEFINES NTC_LATENT_FETCH=2)
  set(gdeflate "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/DecompressGDeflate")
  openntc_add_shaders(TARGET shader_latents HEADER_NAME gdeflate_pass_shaders.h SOURCES "${gdeflate}.comp")
  openntc_add_shaders(TARGET shader_latents HEADER_NAME gdeflate_pass_hlsl_shaders.h SOURCES "${gdeflate}.hlsl" STAGE comp)

  # Ways to bind, in an executable of their own: by number, by index, by address, in push constants.
  # HLSL by number only: glslang's front end knows no arrays of ByteAddressBuffer.
  openntc_add_test(NAME shader_bindings LABEL shader DIRECTORY shader/bindings
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_bindings PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set(bindings "${CMAKE_CURRENT_SOURCE_DIR}/shader/bindings")
  openntc_add_shaders(TARGET shader_bindings HEADER_NAME bound_by_number.h SOURCES "${bindings}/BoundByNumber.comp"
    NETWORK_VERSIONS MEDIUM MATH INT8)
  openntc_add_shaders(TARGET shader_bindings HEADER_NAME bound_by_number_hlsl.h
    SOURCES "${bindings}/BoundByNumber.hlsl" NETWORK_VERSIONS MEDIUM MATH INT8
    STAGE comp)
  openntc_add_shaders(TARGET shader_bindings HEADER_NAME bound_by_push.h SOURCES "${bindings}/BoundByPush.comp"
    NETWORK_VERSIONS MEDIUM MATH INT8 DEFINES UNIFORM_CONSTANTS={0,1})
  openntc_add_shaders(TARGET shader_bindings HEADER_NAME bound_by_address.h TARGET_ENV vulkan1.2
    SOURCES "${bindings}/BoundByAddress.comp" NETWORK_VERSIONS MEDIUM MATH INT8 FP32)
  openntc_add_shaders(TARGET shader_bindings HEADER_NAME bound_by_index.h TARGET_ENV vulkan1.2
    SOURCES "${bindings}/BoundByIndex.comp" NETWORK_VERSIONS MEDIUM MATH INT8 DEFINES NON_UNIFORM_SETS={0,1})

  # A bad permutation does not compile, and the message names the macro.
  foreach(refusal
      "NTC_OUTPUT_MASK=0|NTC_OUTPUT_MASK must be" "NTC_OUTPUT_MASK=0x10000|NTC_OUTPUT_MASK must be"
      "NTC_LINEARISE=3|NTC_LINEARISE must be" "NTC_LINEARISE=2|NTC_CHANNEL_COLOR_SPACES is not defined"
      "NTC_SINGLE_MIP=2|NTC_SINGLE_MIP must be" "NTC_LATENT_SLICES=2|NTC_LATENT_SLICES must be"
      "NTC_CLAMP_TEXELS=2|NTC_CLAMP_TEXELS must be" "NTC_TILE_FALLBACK=2|NTC_TILE_FALLBACK must be"
      "NTC_TILE_REQUESTS=2|NTC_TILE_REQUESTS must be" "NTC_TILE_STAMPS=2|NTC_TILE_STAMPS must be"
      "NTC_TILE_FEEDBACK=2|NTC_TILE_FEEDBACK must be" "NTC_TILE_RATES=2|NTC_TILE_RATES must be" "NTC_MATH=99|NTC_MATH must be"
      "NETWORK_VERSION=7|NETWORK_VERSION must be" "NTC_LATENT_FETCH=3|NTC_LATENT_FETCH must be"
      "NTC_LATENT_FETCH=2|NTC_LATENTS_TEXTURE is for shaders")
    string(REPLACE "|" ";" refusal "${refusal}")
    list(GET refusal 0 define)
    list(GET refusal 1 message)
    set(version -DNETWORK_VERSION=1)
    if(define MATCHES "^NETWORK_VERSION")
      set(version "")
    endif()
    openntc_add_refusal(NAME shader_refuses_${define} LABEL shader REASON "${message}"
      COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" -V --target-env vulkan1.1
        "-I${PROJECT_SOURCE_DIR}/shaders" ${version} "-D${define}" -o refused.spv "${effect_texels}")
  endforeach()

  # Beside an engine's own macros.
  foreach(math 1 4)
    add_test(NAME shader_engine_prelude_${math} COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" -V --quiet --target-env vulkan1.1
      "-I${PROJECT_SOURCE_DIR}/shaders" -DNETWORK_VERSION=1 -DNTC_MATH=${math} -o prelude_${math}.spv
      "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/EnginePrelude.comp")
    set_tests_properties(shader_engine_prelude_${math} PROPERTIES LABELS shader)
  endforeach()

  # Copied into one folder, with another ending, included in any order.
  add_test(NAME shader_flat_copy COMMAND "${CMAKE_COMMAND}" "-DSHADERS=${PROJECT_SOURCE_DIR}/shaders/openntc"
    "-DWORK=${CMAKE_CURRENT_BINARY_DIR}/flat_copy" "-DVALIDATOR=${OPENNTC_GLSLANG_VALIDATOR}"
    -P "${CMAKE_CURRENT_SOURCE_DIR}/shader/flat_copy.cmake")
  set_tests_properties(shader_flat_copy PROPERTIES LABELS shader TIMEOUT 120)

  # Weight fetching, in an executable of its own.
  openntc_add_test(WARM SECONDS 40 NAME shader_fetch LABEL shader DIRECTORY shader/fetch
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_fetch PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_fetch PROPERTIES ENVIRONMENT GALLIVM_PERF=nopt)
  set(fetch_texels "${CMAKE_CURRENT_SOURCE_DIR}/shader/fetch/FetchTexels.comp")
  # Int8 for every network, the half epilogue for one.
  foreach(math INT8 INT8_HALF)
    set(prefix fetch)
    set(networks SMALL LARGE XLARGE GEN3)
    if(math STREQUAL "INT8_HALF")
      set(prefix fetch_half)
      set(networks LARGE)
    endif()
    openntc_add_shaders(TARGET shader_fetch HEADER_NAME ${prefix}_direct.h SOURCES "${fetch_texels}"
      NETWORK_VERSIONS ${networks} MATH ${math}
      DEFINES NTC_TEXELS_PER_INVOCATION={1,2} NTC_WIDE_WEIGHT_LOADS={0,1})
    openntc_add_shaders(TARGET shader_fetch HEADER_NAME ${prefix}_uniform.h SOURCES "${fetch_texels}"
      NETWORK_VERSIONS ${networks} MATH ${math} DEFINES NTC_WEIGHT_FETCH=2 NTC_TEXELS_PER_INVOCATION={1,2})
    openntc_add_shaders(TARGET shader_fetch HEADER_NAME ${prefix}_subgroup.h SOURCES "${fetch_texels}"
      NETWORK_VERSIONS LARGE MATH ${math}
      DEFINES NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET NTC_TEXELS_PER_INVOCATION={1,2} NTC_FLOAT_DOT={0,1}
        NTC_WIDE_WEIGHT_LOADS={0,1})
  endforeach()
  # The forms that are the default on CPU drivers, for every network.
  openntc_add_shaders(TARGET shader_fetch HEADER_NAME fetch_subgroup_default.h SOURCES "${fetch_texels}"
    NETWORK_VERSIONS SMALL LARGE XLARGE GEN3 MATH INT8
    DEFINES NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET NTC_TEXELS_PER_INVOCATION={1,2} NTC_FLOAT_DOT=1
      NTC_WIDE_WEIGHT_LOADS=1)
  foreach(refusal "NTC_WEIGHT_FETCH=3|needs NTC_SUBGROUP_DECODES_ONE_SET" "NTC_WEIGHT_FETCH=4|NTC_WEIGHT_FETCH must be"
      "NTC_TEXELS_PER_INVOCATION=9|NTC_TEXELS_PER_INVOCATION must be")
    string(REPLACE "|" ";" refusal "${refusal}")
    list(GET refusal 0 define)
    list(GET refusal 1 message)
    openntc_add_refusal(NAME shader_refuses_${define} LABEL shader REASON "${message}"
      COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" -V --target-env vulkan1.1
        "-I${PROJECT_SOURCE_DIR}/shaders" -DNETWORK_VERSION=1 "-D${define}" -o refused.spv "${fetch_texels}")
  endforeach()

  # Slices: the ordinary functions with a slice's constants, and rows of constants.
  openntc_add_test(WARM NAME shader_slices LABEL shader DIRECTORY shader/slices
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_slices PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_slices PROPERTIES ENVIRONMENT GALLIVM_PERF=nopt)
  openntc_add_shaders(TARGET shader_slices HEADER_NAME slice_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/slices/SliceTexels.comp" NETWORK_VERSIONS SMALL LARGE MATH INT8)
  openntc_add_shaders(TARGET shader_slices HEADER_NAME slice_shaders_hlsl.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/slices/SliceTexels.hlsl" NETWORK_VERSIONS SMALL LARGE MATH INT8
    STAGE comp)

  # Passes that decode to textures and compare images, in an executable of their own.
  # The encoder on a device, in an executable of its own.
  openntc_add_test(WARM SECONDS 30 NAME shader_training LABEL shader DIRECTORY shader/training
    LIBRARIES openntc_training openntc_device_training openntc::encode openntc::decode openntc_vulkan_harness)
  target_sources(shader_training PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")

  openntc_add_test(WARM SECONDS 10 NAME shader_passes LABEL shader DIRECTORY shader/passes
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_passes PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_passes PROPERTIES ENVIRONMENT GALLIVM_PERF=nopt)
  set(passes "${PROJECT_SOURCE_DIR}/shaders/openntc/passes")
  openntc_add_shaders(TARGET shader_passes HEADER_NAME decompress_shaders.h
    LIST "${CMAKE_CURRENT_SOURCE_DIR}/shader/passes/shaders.txt")
  openntc_add_shaders(TARGET shader_passes HEADER_NAME decompress_hlsl_shaders.h
    SOURCES "${passes}/DecompressToTextures.hlsl" NETWORK_VERSIONS SMALL LARGE MATH INT8 STAGE comp
    DEFINES NTC_DECOMPRESS_CONVERT={,0})
  openntc_add_shaders(TARGET shader_passes HEADER_NAME difference_shaders.h SOURCES "${passes}/ImageDifference.comp")
  openntc_add_shaders(TARGET shader_passes HEADER_NAME difference_hlsl_shaders.h SOURCES "${passes}/ImageDifference.hlsl"
    STAGE comp)

  # Cooperative matrices emulated by arrays, in an executable of their own; the device's where it has them.
  openntc_add_test(WARM SECONDS 45 NAME shader_coopmat LABEL shader DIRECTORY shader/coopmat
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_coopmat PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_coopmat PROPERTIES ENVIRONMENT "${four_lanes}")
  openntc_add_shaders(TARGET shader_coopmat HEADER_NAME coopmat_shaders.h
    LIST "${CMAKE_CURRENT_SOURCE_DIR}/shader/coopmat/shaders.txt")
  openntc_add_shaders(TARGET shader_coopmat HEADER_NAME bench_coopvec.h LIST "${PROJECT_SOURCE_DIR}/examples/coopvec/bench.txt")

  # The renderer, whose shaders are compiled when it runs.
  if(TARGET openntc_renderer_gpu)
    openntc_add_test(WARM SECONDS 20 NAME shader_renderer LABEL shader DIRECTORY shader/renderer LIBRARIES openntc_renderer_gpu openntc_shader_compiler
      DEFINITIONS "OPENNTC_RENDERER_SOURCES=\"${PROJECT_SOURCE_DIR}\"")
    target_sources(shader_renderer PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
    set_tests_properties(shader_renderer PROPERTIES ENVIRONMENT GALLIVM_PERF=nopt)
  endif()

  # Streaming: page table, requests, demand-loaded textures, feedback, in an executable of its own.
  openntc_add_test(WARM SECONDS 90 NAME shader_streaming LABEL shader DIRECTORY shader/streaming
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_streaming PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_streaming PROPERTIES ENVIRONMENT "${four_lanes}")
  set(streaming "${CMAKE_CURRENT_SOURCE_DIR}/shader/streaming")
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME streaming_shaders.h SOURCES "${streaming}/Streaming.comp"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}" NETWORK_VERSIONS SMALL GEN3 MATH INT8 DEFINES NTC_FEEDBACK_SUBGROUP={0,1})
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME streaming_hlsl_shaders.h SOURCES "${streaming}/Streaming.hlsl"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}" NETWORK_VERSIONS SMALL GEN3 MATH INT8 STAGE comp)
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME tile_effect_shaders.h LIST "${streaming}/effects.txt"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}")
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME resolve_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/ResolveFeedback.comp")
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME resolve_hlsl_shaders.h STAGE comp
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/ResolveFeedback.hlsl")
  # In fragment shaders, and where a device has them in ray-generation shaders, which openntc_add_shaders does not know.
  openntc_add_shaders(TARGET shader_streaming HEADER_NAME triangle_shaders.h
    SOURCES "${streaming}/Triangles.vert" "${streaming}/Triangles.frag" INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}"
    NETWORK_VERSIONS SMALL MATH INT8 DEFINES FRAGMENT_WORDS=17 NTC_FEEDBACK_SUBGROUP={0,1})
  target_compile_definitions(shader_streaming PRIVATE
    "STREAMING_RAYS=\"${CMAKE_CURRENT_BINARY_DIR}/streaming_Rays.rgen.spv\"")
  # Fragment and ray-tracing shaders compile and pass the validator.
  foreach(name Streaming.frag Streaming.rgen Streaming.rchit Rays.rgen)
    set(spirv "${CMAKE_CURRENT_BINARY_DIR}/streaming_${name}.spv")
    string(REPLACE "Streaming." "" stage "${name}")
    add_test(NAME shader_streaming_${stage} COMMAND "${OPENNTC_GLSLANG_VALIDATOR}" -V --quiet --target-env vulkan1.2
      "-I${PROJECT_SOURCE_DIR}/shaders" "-I${CMAKE_CURRENT_SOURCE_DIR}" -DNETWORK_VERSION=1 -DNTC_MATH=1 -o "${spirv}"
      "${streaming}/${name}")
    set_tests_properties(shader_streaming_${stage} PROPERTIES LABELS shader FIXTURES_SETUP streaming_${stage})
    add_test(NAME shader_streaming_${stage}_valid COMMAND "${OPENNTC_SPIRV_VAL}" --target-env vulkan1.2 "${spirv}")
    set_tests_properties(shader_streaming_${stage}_valid PROPERTIES LABELS shader FIXTURES_REQUIRED streaming_${stage})
  endforeach()
  set_tests_properties(shader_streaming PROPERTIES FIXTURES_REQUIRED streaming_Rays.rgen)

  # Stochastic filtering, in an executable of its own.
  openntc_add_test(WARM SECONDS 25 NAME shader_filtering LABEL shader DIRECTORY shader/filtering
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_filtering PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_filtering PROPERTIES ENVIRONMENT GALLIVM_PERF=nopt)
  set(filtering "${CMAKE_CURRENT_SOURCE_DIR}/shader/filtering")
  openntc_add_shaders(TARGET shader_filtering HEADER_NAME filtering_shaders.h SOURCES "${filtering}/Filtering.comp"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}")
  openntc_add_shaders(TARGET shader_filtering HEADER_NAME filtering_hlsl_shaders.h SOURCES "${filtering}/Filtering.hlsl"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}" STAGE comp)
  openntc_add_shaders(TARGET shader_filtering HEADER_NAME wave_shaders.h INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}"
    SOURCES "${filtering}/Waves.comp" "${filtering}/Waves.vert" "${filtering}/Waves.frag")
  openntc_add_shaders(TARGET shader_filtering HEADER_NAME wave_hlsl_shaders.h SOURCES "${filtering}/Waves.hlsl"
    INCLUDE_DIRECTORIES "${CMAKE_CURRENT_SOURCE_DIR}" STAGE comp)

  # The code of docs/filtering.md, and the program that draws its pictures and prints its numbers.
  foreach(language glsl hlsl)
    add_test(NAME shader_filtering_page_${language} COMMAND "${CMAKE_COMMAND}" "-DPAGE=${PROJECT_SOURCE_DIR}/docs/filtering.md"
      -DLANGUAGE=${language} "-DSHADERS=${PROJECT_SOURCE_DIR}/shaders" "-DWORK=${CMAKE_CURRENT_BINARY_DIR}/filtering_page"
      "-DVALIDATOR=${OPENNTC_GLSLANG_VALIDATOR}" -P "${filtering}/snippets.cmake")
    set_tests_properties(shader_filtering_page_${language} PROPERTIES LABELS shader)
  endforeach()
  if(TARGET filter_pictures AND NOT OPENNTC_SANITIZE)
    add_dependencies(tests_shader filter_pictures)
    add_test(NAME shader_filtering_pictures COMMAND "${CMAKE_COMMAND}" "-DPROGRAM=$<TARGET_FILE:filter_pictures>"
      "-DPAGE=${PROJECT_SOURCE_DIR}/docs/filtering.md" "-DWORK=${CMAKE_CURRENT_BINARY_DIR}/filtering_pictures"
      -P "${filtering}/pictures.cmake")
    set_tests_properties(shader_filtering_pictures PROPERTIES LABELS shader)
  endif()

  # Block compression, in an executable of its own. An encoder's format is a number more.
  openntc_add_test(WARM SECONDS 90 NAME shader_bc LABEL shader DIRECTORY shader/bc
    LIBRARIES openntc::decode openntc_vulkan_harness Threads::Threads)
  target_sources(shader_bc PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_bc PROPERTIES ENVIRONMENT "${four_lanes}")
  set(bc_formats "NTC_BC_FORMAT={0,1,2,3,4,5,6,7,8,9}")
  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/CompressBlocks.comp"
    DEFINES ${bc_formats} NTC_BC_QUALITY={0,1,2} NTC_BC_SOURCE=0 NTC_BC_TARGET=0)
  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_dot_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/CompressBlocks.comp"
    DEFINES NTC_BC_FORMAT=9 NTC_BC_QUALITY=1 NTC_BC_SOURCE=0 NTC_BC_TARGET=0 NTC_DOT4_SPIRV=1)
  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_hlsl_shaders.h STAGE comp
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/CompressBlocks.hlsl"
    DEFINES ${bc_formats} NTC_BC_QUALITY={0,1,2} NTC_BC_SOURCE=0 NTC_BC_TARGET=0)

  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_image_shaders.h
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/CompressBlocks.comp"
    DEFINES NTC_BC_FORMAT={3,5} NTC_BC_QUALITY=0 NTC_BC_SOURCE=1 NTC_BC_TARGET={0,1})
  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_image_hlsl_shaders.h STAGE comp
    SOURCES "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/CompressBlocks.hlsl"
    DEFINES NTC_BC_FORMAT={3,5} NTC_BC_QUALITY=0 NTC_BC_SOURCE=1 NTC_BC_TARGET={0,1})
  openntc_add_shaders(TARGET shader_bc HEADER_NAME bc_sample_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/bc/SampleBlocks.comp")

  # What feedback costs, measured small.
  if(TARGET bench_feedback AND NOT WIN32)
    openntc_add_test(NAME shader_bench LABEL shader DIRECTORY shader/bench LIBRARIES openntc::openntc
      DEFINITIONS "NTC_PROGRAM=\"$<TARGET_FILE:bench_feedback>\"" "NTC_SCHEMA_DIR=\"${PROJECT_SOURCE_DIR}/schemas\"")
    add_dependencies(shader_bench bench_feedback)
  endif()

  # A small landscape of examples/streaming, rendered streamed and all resident.
  if(TARGET streaming AND NOT WIN32)
    openntc_add_test(NAME shader_landscape LABEL shader DIRECTORY shader/landscape LIBRARIES openntc::openntc
      DEFINITIONS "NTC_PROGRAM=\"$<TARGET_FILE:streaming>\"" "NTC_SCHEMA_DIR=\"${PROJECT_SOURCE_DIR}/schemas\"")
    add_dependencies(shader_landscape streaming)
  endif()

  # Without `precise`: the roundings that a uniform zero keeps.
  openntc_add_test(WARM SECONDS 50 NAME shader_exact LABEL shader DIRECTORY shader/exact
    LIBRARIES openntc::decode openntc_vulkan_harness)
  target_sources(shader_exact PRIVATE "${CMAKE_CURRENT_SOURCE_DIR}/shader/TestDevice.cpp")
  set_tests_properties(shader_exact PROPERTIES ENVIRONMENT "${four_lanes}")
  openntc_add_shaders(TARGET shader_exact HEADER_NAME opaque_shaders.h
    SOURCES "${CMAKE_CURRENT_SOURCE_DIR}/shader/exact/OpaqueTexels.comp"
    NETWORK_VERSIONS SMALL MEDIUM LARGE XLARGE MATH INT8 INT8_HALF FP8 FP16 FP32)
  # Slang is refused unless it is told how roundings are kept.
  set(slang "${OPENNTC_GLSLANG_VALIDATOR}" -D -V --quiet --target-env vulkan1.1 -S comp -e main
    "-I${PROJECT_SOURCE_DIR}/shaders" -DNETWORK_VERSION=1 -D__SLANG__=1
    "${PROJECT_SOURCE_DIR}/shaders/openntc/passes/DecodeTexels.hlsl")
  openntc_add_refusal(NAME shader_refuses_slang LABEL shader REASON "NTC_OPAQUE_ZERO.*NTC_TRUST_PRECISE"
    COMMAND ${slang} -o slang_refused.spv)
  add_test(NAME shader_takes_slang COMMAND ${slang} -DNTC_TRUST_PRECISE=1 -o slang_taken.spv)
  set_tests_properties(shader_takes_slang PROPERTIES LABELS shader)
endif()

# What the headers' text must and must not hold; needs neither compiler nor device.
openntc_add_test(WARM NAME shader_source LABEL shader DIRECTORY shader/source LIBRARIES openntc::openntc
  DEFINITIONS "NTC_SHADER_DIR=\"${PROJECT_SOURCE_DIR}/shaders\"")

# Hosts with function-like macros of the names that shaders call; standard headers first, which may undefine them.
if(NOT MSVC)
  add_test(NAME shader_host_macros COMMAND "${CMAKE_CXX_COMPILER}" -std=c++20 -fsyntax-only -Wall -Wextra -Werror
    "-I${PROJECT_SOURCE_DIR}/shaders" "${CMAKE_CURRENT_SOURCE_DIR}/shader/entries/HostMacros.cpp")
  set_tests_properties(shader_host_macros PROPERTIES LABELS shader)
endif()

# The compile matrix needs the compiler only, no device.
if(NOT TARGET openntc_shader_compiler AND NOT OPENNTC_BUILD_EXAMPLES)
  add_subdirectory("${PROJECT_SOURCE_DIR}/examples/shader_compiler" "${PROJECT_BINARY_DIR}/examples/shader_compiler")
endif()
if(TARGET openntc_shader_compiler)
  openntc_add_test(WARM SECONDS 100 NAME shader_matrix LABEL shader DIRECTORY shader/matrix
    LIBRARIES openntc::openntc openntc_shader_compiler
    DEFINITIONS "NTC_SHADER_DIR=\"${PROJECT_SOURCE_DIR}/shaders\""
      "NTC_MATRIX_DIR=\"${CMAKE_CURRENT_SOURCE_DIR}/shader/matrix\"")
  set_tests_properties(shader_matrix PROPERTIES PROCESSORS 2)
endif()

# SPIR-V of cooperative vectors that is kept in the tree: of the sources as they are, compiled afresh where that can be, and of
# the right shape.
if(NOT OPENNTC_BUILD_EXAMPLES)
  add_subdirectory("${PROJECT_SOURCE_DIR}/examples/coopvec" "${PROJECT_BINARY_DIR}/examples/coopvec")
endif()
openntc_add_test(NAME shader_coopvec LABEL shader DIRECTORY shader/coopvec LIBRARIES openntc::decode
  DEFINITIONS "NTC_COOPVEC_FOLDER=\"${PROJECT_BINARY_DIR}/examples/coopvec/modules\"")
# The shader as C++, another one in each of these files.
file(GLOB coopvec_variants CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/shader/coopvec/variant_*.cpp")
set_source_files_properties(${coopvec_variants} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
foreach(kind coopvec coopmat)
  add_test(NAME shader_${kind}_sources COMMAND "${CMAKE_COMMAND}" "-DCHECK=${CMAKE_CURRENT_BINARY_DIR}/${kind}"
    "-DOPENNTC_COOPVEC_GLSLANG=${OPENNTC_COOPVEC_GLSLANG}" -P "${PROJECT_SOURCE_DIR}/examples/${kind}/update.cmake")
  set_tests_properties(shader_${kind}_sources PROPERTIES LABELS shader TIMEOUT 600)
endforeach()
