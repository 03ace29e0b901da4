# combine_sources(): call once, when every target is known, before precompile_headers(). The compiler
# then reads the project's headers, and instantiates their templates, once for several source files:
# less than half of the work. Each file compiles by itself all the same: the preset `sanitize` and
# -DTACTUS_COMBINE=OFF do so. build/sources/compile_commands.json has a command for each file.
option(TACTUS_COMBINE "compile several source files as one" ON)
set(files_at_once 8)
# What cannot stand beside others of its target: names of its own that others have too.
set(compiled_alone "/driver\\.cpp$|/surfaces\\.cpp$|externals/phantom/(network_message|network_settings|driver_use)\\.cpp$"
  "|externals/stress_haptic/picture\\.cpp$|tests/fem/cost_test\\.cpp$|tests/externals/greed_test\\.cpp$"
  "|tests/devices/live/.*_test\\.cpp$|tests/core/haptic/allocation_test\\.cpp$"
  "|_avx2\\.cpp$|_avx512\\.cpp$")
string(CONCAT compiled_alone ${compiled_alone})

# combine_library(TARGET SOURCE...): by CMake's own means
function(combine_library target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE ${files_at_once})
  get_target_property(folder ${target} SOURCE_DIR)
  foreach(source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
    if(source MATCHES "${compiled_alone}" OR source MATCHES "^${CMAKE_SOURCE_DIR}/tests/")
      set_source_files_properties(${source} TARGET_DIRECTORY ${target}
        PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Of a type in a .cpp that is included: as if it were a header.
    target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-Wno-subobject-linkage>)
  endif()
endfunction()

# combine_tests(TARGET SOURCE...): tests name their helpers alike, so each file gets a namespace
function(combine_tests target)
  get_target_property(folder ${target} SOURCE_DIR)
  get_target_property(output ${target} BINARY_DIR)
  set(alone "")
  set(batch "")
  set(number 0)
  list(LENGTH ARGN left)
  foreach(source IN LISTS ARGN)
    math(EXPR left "${left} - 1")
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
    if(source MATCHES "_test\\.cpp$" AND NOT source MATCHES "${compiled_alone}")
      list(APPEND batch ${source})
    else()
      list(APPEND alone ${source})
    endif()
    list(LENGTH batch count)
    if(count EQUAL files_at_once OR (left EQUAL 0 AND count GREATER 0))
      set(file ${output}/${target}_${number}.cpp)
      add_custom_command(OUTPUT ${file}
        COMMAND ${TACTUS_PYTHON} ${CMAKE_SOURCE_DIR}/cmake/combine_tests.py ${file} ${batch}
        DEPENDS ${batch} ${CMAKE_SOURCE_DIR}/cmake/combine_tests.py VERBATIM)
      set_source_files_properties(${file} TARGET_DIRECTORY ${target} PROPERTIES GENERATED ON)
      set_property(GLOBAL APPEND PROPERTY TACTUS_COMBINED_TESTS ${file})
      list(APPEND alone ${file})
      set(batch "")
      math(EXPR number "${number} + 1")
    endif()
  endforeach()
  set_property(TARGET ${target} PROPERTY SOURCES ${alone})
  add_dependencies(${target} combined_tests)
endfunction()

function(combine_sources)
  if(NOT TACTUS_COMBINE)
    return()
  endif()
  targets_below(${CMAKE_SOURCE_DIR} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(folder ${target} SOURCE_DIR)
    get_target_property(sources ${target} SOURCES)
    list(LENGTH sources count)
    if(count LESS 3)
      continue()
    endif()
    if((type MATCHES "(STATIC|OBJECT)_LIBRARY" AND NOT folder MATCHES "^${CMAKE_SOURCE_DIR}/tests")
       OR folder MATCHES "^${CMAKE_SOURCE_DIR}/programs" OR target MATCHES "_threads(_test)?$")
      combine_library(${target} ${sources})
    elseif(type STREQUAL "EXECUTABLE" AND folder MATCHES "^${CMAKE_SOURCE_DIR}/tests" AND target MATCHES "_test$")
      combine_tests(${target} ${sources})
    endif()
  endforeach()
  get_property(files GLOBAL PROPERTY TACTUS_COMBINED_TESTS)
  if(files)
    add_custom_target(combined_tests DEPENDS ${files})
  endif()
endfunction()
