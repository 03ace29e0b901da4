# `cmake --install build [--prefix FOLDER] [--component NAME]`; included after all targets exist. Components:
#   pd           the library folder, PDLIBDIR/tactus: externals, help, abstractions, bodies; needs only Pd
#   solvers      in the library folder: finite-element programs that externals start, with their libraries
#   programs     users' programs, in bin/
#   development  headers, static libraries and find_package(tactus)
# docs/install.md explains their use.
if(TACTUS_SANITIZE)
  return() # a build for tests; it is not installed
endif()
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Every Pd on Linux looks into ~/.local/lib/pd/extra, /usr/local/lib/pd-externals and, where it is
# itself in /usr, /usr/lib/pd/extra. The prefix is known when the installation runs: it decides then.
set(PDLIBDIR "" CACHE PATH "where Pd looks for library folders; empty: by the prefix, under it")
if(PDLIBDIR)
  set(pd_folder ${PDLIBDIR})
else()
  set(pd_folder "\${tactus_pd_folder}")
  install(CODE [[
    if("${CMAKE_INSTALL_PREFIX}" MATCHES "/usr/local/?$")
      set(tactus_pd_folder lib/pd-externals)
    else()
      set(tactus_pd_folder lib/pd/extra)
    endif()
  ]] ALL_COMPONENTS)
endif()

# The externals by name, so that one that is not built ends the installation; the rest of the library
# folder as it is staged.
get_property(modules GLOBAL PROPERTY TACTUS_MODULES)
install(TARGETS ${modules} LIBRARY DESTINATION ${pd_folder}/tactus COMPONENT pd
                           RUNTIME DESTINATION ${pd_folder}/tactus COMPONENT pd)
install(DIRECTORY ${TACTUS_STAGE}/ DESTINATION ${pd_folder}/tactus USE_SOURCE_PERMISSIONS COMPONENT pd
        PATTERN "*.${pd_legacy}${pd_processor}" EXCLUDE
        PATTERN "*.${pd_system}-${pd_processor}-64.${pd_library}" EXCLUDE
        PATTERN modal_fem EXCLUDE PATTERN part_stress EXCLUDE PATTERN "*_sheet.py" EXCLUDE)
foreach(solver modal_fem part_stress)
  if(TARGET ${solver})
    install(TARGETS ${solver} RUNTIME DESTINATION ${pd_folder}/tactus COMPONENT solvers)
  endif()
endforeach()
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE ${CMAKE_SOURCE_DIR}/CHANGELOG.md
              ${CMAKE_SOURCE_DIR}/packaging/third_party.md ${CMAKE_SOURCE_DIR}/packaging/library/README.md
        DESTINATION ${pd_folder}/tactus COMPONENT pd)
install(DIRECTORY ${CMAKE_SOURCE_DIR}/docs DESTINATION ${pd_folder}/tactus COMPONENT pd
        FILES_MATCHING PATTERN "*.md" PATTERN "*.pd" PATTERN "*.png" PATTERN results/build_time.md EXCLUDE)

foreach(program haptic_server haptic_check)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
  endif()
endforeach()
# These programs use files beside themselves, so they get their own folder and a link in bin/.
set(own_folder ${CMAKE_INSTALL_LIBEXECDIR}/tactus)
file(RELATIVE_PATH link_to_own_folder ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBEXECDIR}/tactus)
foreach(program modal_fem part_stress)
  if(TARGET ${program})
    file(GLOB sheets ${CMAKE_SOURCE_DIR}/programs/${program}/*_sheet.py)
    install(TARGETS ${program} RUNTIME DESTINATION ${own_folder} COMPONENT programs)
    install(FILES ${sheets} DESTINATION ${own_folder} COMPONENT programs)
    file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/links)
    file(CREATE_LINK ${link_to_own_folder}/${program} ${CMAKE_BINARY_DIR}/links/${program} SYMBOLIC)
    install(FILES ${CMAKE_BINARY_DIR}/links/${program} DESTINATION ${CMAKE_INSTALL_BINDIR}
            COMPONENT programs)
  endif()
endforeach()
foreach(solver slepc_solve petsc_solve)
  if(TARGET ${solver})
    install(TARGETS ${solver} RUNTIME DESTINATION ${own_folder} COMPONENT programs)
  endif()
endforeach()

# tactus::core and, where they are built, tactus::files, tactus::fem, tactus::devices, tactus::net and
# tactus::net_sockets.
foreach(module core files fem devices net net_sockets)
  if(NOT TARGET tactus_${module})
    continue()
  endif()
  set_target_properties(tactus_${module} PROPERTIES EXPORT_NAME ${module})
  install(TARGETS tactus_${module} EXPORT tactus COMPONENT development
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tactus)
  if(IS_DIRECTORY ${CMAKE_SOURCE_DIR}/${module})
    install(DIRECTORY ${CMAKE_SOURCE_DIR}/${module} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tactus
            COMPONENT development FILES_MATCHING PATTERN "*.hpp")
  endif()
endforeach()
target_compile_features(tactus_core INTERFACE cxx_std_20)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/tactus)
install(EXPORT tactus NAMESPACE tactus:: FILE tactusTargets.cmake DESTINATION ${package_folder}
        COMPONENT development)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/tactusConfig.cmake.in
  ${CMAKE_BINARY_DIR}/tactusConfig.cmake INSTALL_DESTINATION ${package_folder})
# Before 1.0 a new minor version may change declarations.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/tactusConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/tactusConfig.cmake ${CMAKE_BINARY_DIR}/tactusConfigVersion.cmake
        DESTINATION ${package_folder} COMPONENT development)
