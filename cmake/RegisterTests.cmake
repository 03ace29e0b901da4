# How tests are registered.
#
# A case that takes long says so: in doctest's suite "slow", or by pytest's mark `slow`. What has such cases is two
# entries: NAME without them, which ./test runs, and NAME_slow with them alone, labelled slow, which ./test --full adds.
# In a build with sanitizers Pd's patches and programs as their users run them are slow as a whole.
# What is compiled anew under the thread sanitizer is labelled threads and built for ./test --sanitize alone (the target
# `watched`).

# What every test in Python knows; under sanitizers, whose library comes before Pd, a `pd` that loads it is first in the path.
set(test_environment "TACTUS_STAGE=${TACTUS_STAGE}" "TACTUS_BUILD=${CMAKE_BINARY_DIR}")
set(test_path "")
if(TACTUS_SANITIZE)
  execute_process(COMMAND ${CMAKE_CXX_COMPILER} -print-file-name=libclang_rt.asan-${CMAKE_SYSTEM_PROCESSOR}.so
                  OUTPUT_VARIABLE sanitizers OUTPUT_STRIP_TRAILING_WHITESPACE)
  find_program(TACTUS_PD pd REQUIRED)
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/sanitized/pd @ONLY CONTENT [[#!/bin/sh
LD_PRELOAD="@sanitizers@" ASAN_OPTIONS=detect_leaks=0 exec @TACTUS_PD@ "$@"
]])
  file(CHMOD ${CMAKE_BINARY_DIR}/sanitized/pd PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  list(APPEND test_environment "TACTUS_PD_SLOW=10")
  set(test_path "PATH=path_list_prepend:${CMAKE_BINARY_DIR}/sanitized")
endif()

# slow_cases(VARIABLE FILE...): OFF; ON where a file says that one of its cases is slow; ALL where a Python file says it
# of the whole
function(slow_cases variable)
  set(found OFF)
  foreach(file IN LISTS ARGN)
    file(STRINGS ${file} lines REGEX "test_suite\\(\"slow\"\\)|mark\\.slow")
    if(lines MATCHES "(^|;)pytestmark")
      set(found ALL)
      break()
    elseif(lines)
      set(found ON)
    endif()
  endforeach()
  set(${variable} ${found} PARENT_SCOPE)
endfunction()

# unit_test(NAME PROGRAM [BEHIND WORD...] [SOURCES FILE...]): a program of doctest cases, run behind these words (the
# double of a device); its sources are the target's, unless they are given
function(unit_test name program)
  cmake_parse_arguments(PARSE_ARGV 2 arg "" "" "BEHIND;SOURCES")
  get_target_property(folder ${program} SOURCE_DIR)
  if(NOT arg_SOURCES)
    get_target_property(arg_SOURCES ${program} SOURCES)
  endif()
  set(sources "")
  foreach(source IN LISTS arg_SOURCES)
    if(source MATCHES "\\.cpp$")
      cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder})
      list(APPEND sources ${source})
    endif()
  endforeach()
  slow_cases(slow ${sources})
  set(command ${program}) # a target's name: an emulator comes before it where there is one
  if(arg_BEHIND)
    set(command ${arg_BEHIND} $<TARGET_FILE:${program}>)
  endif()
  add_test(NAME ${name} COMMAND ${command} --test-suite-exclude=slow)
  if(slow)
    add_test(NAME ${name}_slow COMMAND ${command} --test-suite=slow)
    set_tests_properties(${name}_slow PROPERTIES LABELS slow TIMEOUT 900)
  endif()
endfunction()

# python_test(NAME FILE_OR_FOLDER...): pytest cases (tests/pytest.ini), with what every test in Python knows
function(python_test name)
  set(files "")
  foreach(file IN LISTS ARGN)
    cmake_path(ABSOLUTE_PATH file)
    if(IS_DIRECTORY ${file})
      file(GLOB file CONFIGURE_DEPENDS ${file}/test_*.py)
    endif()
    list(APPEND files ${file})
  endforeach()
  slow_cases(slow ${files})
  set(command ${TACTUS_PYTHON} -B -m pytest)
  set(entries "")
  if(NOT slow STREQUAL ALL)
    add_test(NAME ${name} COMMAND ${command} -m "not slow" ${files})
    list(APPEND entries ${name})
  endif()
  if(slow)
    add_test(NAME ${name}_slow COMMAND ${command} -m slow ${files})
    list(APPEND entries ${name}_slow)
  endif()
  set_tests_properties(${entries} PROPERTIES TIMEOUT 900 ENVIRONMENT "${test_environment}"
                       ENVIRONMENT_MODIFICATION "${test_path}")
  if(TACTUS_SANITIZE AND NOT name MATCHES "^(max_|sanitizers_see)")
    set_tests_properties(${entries} PROPERTIES LABELS slow)
  elseif(slow)
    set_tests_properties(${name}_slow PROPERTIES LABELS slow)
  endif()
endfunction()

# test_properties(NAME... PROPERTIES KEY VALUE...): set_tests_properties() of both entries, where they are; ENVIRONMENT
# and LABELS are added to what is there
function(test_properties)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "" "PROPERTIES")
  foreach(name IN LISTS arg_UNPARSED_ARGUMENTS)
    foreach(entry ${name} ${name}_slow)
      if(TEST ${entry})
        foreach(property ENVIRONMENT LABELS)
          get_test_property(${entry} ${property} before)
          if(before STREQUAL NOTFOUND)
            set(before "")
          endif()
          set(${property} ${before})
        endforeach()
        set_tests_properties(${entry} PROPERTIES ${arg_PROPERTIES})
        foreach(property ENVIRONMENT LABELS)
          get_test_property(${entry} ${property} after)
          if(after STREQUAL NOTFOUND)
            continue()
          endif()
          list(APPEND ${property} ${after})
          list(REMOVE_DUPLICATES ${property})
          set_property(TEST ${entry} PROPERTY ${property} "${${property}}")
        endforeach()
      endif()
    endforeach()
  endforeach()
endfunction()

# The thread sanitizer, whose library and the address sanitizer's exclude each other.
set(TACTUS_WATCH_THREADS OFF)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT TACTUS_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_FLAGS -fsanitize=thread)
  check_cxx_source_compiles("int main() { return 0; }" TACTUS_HAS_THREAD_SANITIZER)
  unset(CMAKE_REQUIRED_FLAGS)
  set(TACTUS_WATCH_THREADS ${TACTUS_HAS_THREAD_SANITIZER})
endif()
if(TACTUS_WATCH_THREADS)
  add_custom_target(watched)
  add_test(NAME watched COMMAND ${CMAKE_COMMAND} --build ${CMAKE_BINARY_DIR} --target watched)
  set_tests_properties(watched PROPERTIES LABELS threads FIXTURES_SETUP watched TIMEOUT 1800)
endif()

# watch_threads(TARGET...): compiled under the thread sanitizer, for the target `watched` alone
function(watch_threads)
  foreach(target IN LISTS ARGN)
    target_compile_options(${target} PUBLIC -O1 -fsanitize=thread -g1)
    target_link_options(${target} PUBLIC -fsanitize=thread)
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL ON)
    add_dependencies(watched ${target})
  endforeach()
endfunction()

# watched_test(NAME...): these tests run what is watched
function(watched_test)
  test_properties(${ARGN} PROPERTIES LABELS threads FIXTURES_REQUIRED watched TIMEOUT 300)
endfunction()
