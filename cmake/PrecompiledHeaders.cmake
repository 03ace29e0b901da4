# precompile_headers(): call once, when every target is known. The build with sanitizers then reads the
# standard library's headers once for all files that are compiled alike, which saves it a seventh of its
# time. g++ reads every file by itself, so that a missing include is found.
set(often_included <algorithm> <array> <atomic> <charconv> <chrono> <cmath> <complex> <cstddef> <cstdint>
  <cstdio> <cstdlib> <cstring> <fstream> <functional> <limits> <map> <memory> <mutex> <numbers> <optional>
  <random> <span> <sstream> <string> <string_view> <thread> <utility> <vector>)

# targets_below(FOLDER VARIABLE): the targets made in a folder and below it
function(targets_below folder variable)
  get_property(found DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below IN LISTS folders)
    targets_below(${below} more)
    list(APPEND found ${more})
  endforeach()
  set(${variable} ${found} PARENT_SCOPE)
endfunction()

function(precompile_headers)
  if(NOT TACTUS_SANITIZE)
    return()
  endif()
  targets_below(${CMAKE_SOURCE_DIR} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(folder ${target} SOURCE_DIR)
    get_target_property(sources ${target} SOURCES)
    # Libraries and programs have addresses of different kinds, tests less optimisation, core's tests
    # another (tests/CMakeLists.txt).
    if(sources MATCHES "\\.c(;|$)")
      continue()
    elseif(folder STREQUAL "${CMAKE_SOURCE_DIR}/tests" AND type STREQUAL "EXECUTABLE")
      set(kind CORE_TESTS)
    elseif(folder MATCHES "^${CMAKE_SOURCE_DIR}/tests" AND type STREQUAL "EXECUTABLE")
      set(kind TESTS)
    elseif(type STREQUAL "EXECUTABLE")
      set(kind PROGRAMS)
    elseif(type MATCHES "(STATIC|OBJECT|MODULE)_LIBRARY" AND NOT folder MATCHES "^${CMAKE_SOURCE_DIR}/tests")
      set(kind LIBRARIES)
    else()
      continue()
    endif()
    get_property(first GLOBAL PROPERTY TACTUS_FIRST_OF_${kind})
    if(first)
      target_precompile_headers(${target} REUSE_FROM ${first})
    else()
      set_property(GLOBAL PROPERTY TACTUS_FIRST_OF_${kind} ${target})
      target_precompile_headers(${target} PRIVATE ${often_included})
    endif()
  endforeach()
endfunction()
