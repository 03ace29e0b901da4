# precompile_headers(): call once, when all targets exist. The standard library's headers are most of the
# compiler's input per source file; they are read once for all files with equal compiler options. Missing
# includes are still found: tests/core/check_includes.py checks the header of every name of std; with
# -DTACTUS_PRECOMPILE=OFF the compiler reads every file separately.
option(TACTUS_PRECOMPILE "read the standard library's headers once for all files" ON)
set(often_included <algorithm> <array> <atomic> <bit> <charconv> <chrono> <cmath> <complex> <concepts>
  <condition_variable> <cstddef> <cstdint> <cstdio> <cstdlib> <cstring> <deque> <fstream> <functional>
  <initializer_list> <limits> <map> <memory> <mutex> <numbers> <optional> <random> <span> <sstream>
  <stdexcept> <string> <string_view> <system_error> <thread> <type_traits> <utility> <variant> <vector>)

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
  if(NOT TACTUS_PRECOMPILE)
    return()
  endif()
  targets_below(${CMAKE_SOURCE_DIR} targets)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    get_target_property(folder ${target} SOURCE_DIR)
    get_target_property(sources ${target} SOURCES)
    get_target_property(options ${target} COMPILE_OPTIONS)
    get_target_property(libraries ${target} LINK_LIBRARIES)
    get_target_property(disabled ${target} DISABLE_PRECOMPILE_HEADERS)
    if(disabled) # the first target of a group must build the header
      continue()
    endif()
    if(sources MATCHES "\\.c(;|$)" OR NOT sources MATCHES "\\.cpp")
      continue()
    endif()
    # Targets share a header if they are of one group: libraries or programs (which differ in
    # position-independent code); of what is installed, of the tests, or of core's tests (which differ in
    # optimisation); with the thread sanitizer or without it.
    if(type STREQUAL "EXECUTABLE")
      set(kind PROGRAMS)
    elseif(type MATCHES "(STATIC|OBJECT|MODULE)_LIBRARY"
           AND NOT (TACTUS_SANITIZE AND folder MATCHES "^${CMAKE_SOURCE_DIR}/tests")) # few targets, with two sets of options
      set(kind LIBRARIES)
    else()
      continue()
    endif()
    if(target MATCHES "^(core_.*|files|externals_greed)_test$") # with -O1
      string(APPEND kind _OF_CORE_TESTS)
    elseif(folder MATCHES "^${CMAKE_SOURCE_DIR}/tests")
      string(APPEND kind _OF_TESTS)
    endif()
    if("${options};${libraries}" MATCHES "fsanitize=thread|watched_threads")
      string(APPEND kind _WATCHED)
    endif()
    get_property(first GLOBAL PROPERTY TACTUS_FIRST_OF_${kind})
    # A target with its own definitions cannot share the header.
    get_target_property(definitions ${target} COMPILE_DEFINITIONS)
    if(definitions AND NOT first)
      continue()
    endif()
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>) # required by ccache
      if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
        # More false warnings of std::string's operator+ (GCC bug 105651, see CompilerRules.cmake).
        target_compile_options(${target} PRIVATE
          $<$<COMPILE_LANGUAGE:CXX>:-Wno-stringop-overflow> $<$<COMPILE_LANGUAGE:CXX>:-Wno-array-bounds>)
      endif()
    endif()
    if(first)
      target_precompile_headers(${target} REUSE_FROM ${first})
    else()
      set_property(GLOBAL PROPERTY TACTUS_FIRST_OF_${kind} ${target})
      target_precompile_headers(${target} PRIVATE ${often_included})
    endif()
  endforeach()
endfunction()
