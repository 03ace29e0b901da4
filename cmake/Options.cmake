# Parts of the house that need other libraries. AUTO takes what this system has and says in one line
# what is left out; ON ends the configuration when something is missing; OFF leaves the part out.
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

# Modules for Max: natively for the tests alone, which load them into a host of ours.
if(WIN32 OR APPLE)
  set(max_initially ON)
elseif(CMAKE_CROSSCOMPILING)
  set(max_initially OFF)
else()
  set(max_initially ${TACTUS_TESTS})
endif()
option(TACTUS_MAX "modules for Max" ${max_initially})
