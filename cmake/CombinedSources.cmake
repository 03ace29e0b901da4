# combine_sources(): call once, when every target is known, before precompile_headers(). The compiler
# then reads the project's headers, and instantiates their templates, once for several source files:
# less than half of the work. Each file compiles by itself all the same: the preset `sanitize` and
# -DTACTUS_COMBINE=OFF do so. build/sources/compile_commands.json has a command for each file.
option(TACTUS_COMBINE "compile several source files as one" ON)
set(files_at_once 8)
# What cannot stand beside others of its target: names of its own that others have too.
set(compiled_alone "/driver\\.cpp$|/surfaces\\.cpp$|_avx2\\.cpp$|_avx512\\.cpp$"
  "|core/reed/bore/(termination_tables|pole_fit|brass)\\.cpp$|core/footstep/(room|sole_sensor)\\.cpp$|net/client\\.cpp$|fem/mesh/prism\\.cpp$"
  "|externals/phantom/(network_message|network_settings|driver_use)\\.cpp$|externals/stress_haptic/picture\\.cpp$"
  "|tests/fem/cost_test\\.cpp$|tests/externals/greed_test\\.cpp$|tests/devices/live/.*_test\\.cpp$"
  "|tests/core/haptic/allocation_test\\.cpp$")
# What tests/externals compiles anew under the thread sanitizer is an object of its own in its library: one
# with others would bring their definitions twice.
set(compiled_anew "|core/(design|stress)/|core/declaration_text\\.cpp$|core/haptic/chain/velocity\\.cpp$"
  "|core/modal/table/(loaded_table|resolved_modes)\\.cpp$|${CMAKE_SOURCE_DIR}/files/")
string(CONCAT compiled_alone ${compiled_alone} ${compiled_anew})

# combine_library(TARGET SOURCE...): by CMake's own means, a folder at a time, so that a new file meets the
# names of its neighbours alone
function(combine_library target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(folder ${target} SOURCE_DIR)
  foreach(source IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
    if(NOT source MATCHES "${compiled_alone}" AND NOT source MATCHES "^${CMAKE_SOURCE_DIR}/tests/")
      cmake_path(GET source PARENT_PATH group)
      cmake_path(RELATIVE_PATH group BASE_DIRECTORY ${CMAKE_SOURCE_DIR})
      string(MAKE_C_IDENTIFIER "${group}" group)
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${group})
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
       OR folder MATCHES "^${CMAKE_SOURCE_DIR}/programs" OR target MATCHES "_threads(_test)?$|^max_(host|shell_objects)")
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
