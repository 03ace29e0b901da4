# Programs over the finite elements, the MPI engines that they run, and tables made without them.

# fem_program(NAME SHEET): the program of this folder's sources, with the script that draws its sheet,
# and a copy of both in the library folder, from where externals start it
function(fem_program name sheet)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE tactus_body tactus_core)
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND ${CMAKE_COMMAND} -E make_directory ${TACTUS_STAGE}
    COMMAND ${CMAKE_COMMAND} -E copy_if_different $<TARGET_FILE:${name}>
            ${CMAKE_CURRENT_SOURCE_DIR}/${sheet} ${TACTUS_STAGE})
  configure_file(${sheet} ${CMAKE_CURRENT_BINARY_DIR}/${sheet} COPYONLY)
endfunction()

# mpi_engine(PROGRAM ENGINE MODULE...): builds the optional program ENGINE/ENGINE_solve.cpp, which `PROGRAM
# --engine ENGINE` runs under mpirun, if pkg-config finds the modules
function(mpi_engine program engine)
  find_package(PkgConfig QUIET)
  if(PKG_CONFIG_FOUND AND NOT TACTUS_SANITIZE)
    pkg_check_modules(${engine} QUIET IMPORTED_TARGET ${ARGN})
  endif()
  if(NOT ${engine}_FOUND)
    message(STATUS "Left out: ${program} --engine ${engine}: install Debian's lib${engine}-real-dev and openmpi-bin")
    return()
  endif()
  set(solver ${engine}_solve)
  add_executable(${solver} ${engine}/${solver}.cpp)
  target_include_directories(${solver} PRIVATE ${CMAKE_SOURCE_DIR})
  target_include_directories(${solver} SYSTEM PRIVATE ${${engine}_INCLUDE_DIRS})
  target_compile_options(${solver} PRIVATE -Wno-pedantic) # PETSc's macros
  target_link_libraries(${solver} PRIVATE ${${engine}_LINK_LIBRARIES})
  set_target_properties(${solver} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
endfunction()

# closed_form_table(TABLE SCRIPT EXTERNAL): a table for the help patch and the tests of an external, which
# the script of this folder writes into the library folder from a closed form
function(closed_form_table table script external)
  find_program(TACTUS_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
  set(path ${TACTUS_STAGE}/${table})
  add_custom_command(OUTPUT ${path}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${TACTUS_STAGE}
    COMMAND ${TACTUS_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/${script} ${path}
    DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${script} ${CMAKE_CURRENT_SOURCE_DIR}/../table_file.py
    COMMENT "Writing ${table}")
  add_custom_target(${table} ALL DEPENDS ${path})
  foreach(bits IN LISTS PD_FLOAT_SIZES)
    add_dependencies(${external}_f${bits} ${table})
  endforeach()
endfunction()
