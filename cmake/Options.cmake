# Parts of the project that need other libraries. AUTO builds a part if its libraries are found, and prints
# one line otherwise; ON ends the configuration if a library is missing; OFF leaves the part out.
set(TACTUS_FEM AUTO CACHE STRING "finite elements, modal_fem and part_stress: AUTO, ON or OFF")
set(TACTUS_DEVICES AUTO CACHE STRING "drivers of real haptic devices: AUTO, ON or OFF")
foreach(option TACTUS_FEM TACTUS_DEVICES)
  set_property(CACHE ${option} PROPERTY STRINGS AUTO ON OFF)
  if(NOT ${option} MATCHES "^(AUTO|ON|OFF)$")
    message(FATAL_ERROR "${option}: ${${option}}: expected AUTO, ON or OFF")
  endif()
endforeach()

# leave_out(OPTION WHAT REASON): says that WHAT is not built; an error where OPTION is ON
function(leave_out option what reason)
  if(${option} STREQUAL "ON")
    message(FATAL_ERROR "${what}: ${reason} (${option} is ON)")
  endif()
  message(STATUS "Left out: ${what}: ${reason}")
endfunction()

# AUTO: on Windows and macOS; natively only for the tests, which load the modules into a mock host. AUTO is
# evaluated at each configuration, since ./play (without tests) and ./test share a build folder.
set(TACTUS_MAX AUTO CACHE STRING "modules for Max: AUTO, ON or OFF")
set_property(CACHE TACTUS_MAX PROPERTY STRINGS AUTO ON OFF)
if(NOT TACTUS_MAX MATCHES "^(AUTO|ON|OFF)$")
  message(FATAL_ERROR "TACTUS_MAX: ${TACTUS_MAX}: expected AUTO, ON or OFF")
endif()
if(TACTUS_MAX STREQUAL "AUTO")
  if(WIN32 OR APPLE)
    set(TACTUS_MAX ON)
  elseif(CMAKE_CROSSCOMPILING)
    set(TACTUS_MAX OFF)
  else()
    set(TACTUS_MAX ${TACTUS_TESTS})
  endif()
endif()
# What another system's build takes of a build of this machine: the renders that its own are compared with, and the
# declarations of the objects, if nothing here runs its programs.
if(CMAKE_CROSSCOMPILING)
  set(TACTUS_REFERENCE ${CMAKE_SOURCE_DIR}/build CACHE PATH "a build of this machine")
endif()
