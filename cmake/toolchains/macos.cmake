# macOS 11 and newer by Debian's clang and lld, without Apple's SDK: scripts/cross_root makes BUILD/sysroot, which has
# headers, libSystem's names and LLVM's C++ library. The presets `macos-arm64` and `macos-x86_64` name this file and set
# TACTUS_MACOS_PROCESSOR.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TACTUS_MACOS_PROCESSOR)
set(CMAKE_SYSTEM_NAME Darwin)
set(CMAKE_SYSTEM_PROCESSOR ${TACTUS_MACOS_PROCESSOR})
set(CMAKE_C_COMPILER clang-14)
set(CMAKE_CXX_COMPILER clang++-14)
foreach(language C CXX)
  set(CMAKE_${language}_COMPILER_TARGET ${TACTUS_MACOS_PROCESSOR}-apple-macos11)
endforeach()
foreach(tool AR RANLIB NM STRIP OBJDUMP INSTALL_NAME_TOOL)
  string(TOLOWER ${tool} name)
  string(REPLACE _ - name ${name})
  find_program(CMAKE_${tool} llvm-${name}-14)
endforeach()
set(TACTUS_SYSROOT ${CMAKE_BINARY_DIR}/sysroot CACHE PATH "what scripts/cross_root made")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES TACTUS_SYSROOT)
set(CMAKE_OSX_SYSROOT ${TACTUS_SYSROOT} CACHE PATH "" FORCE)
set(CMAKE_OSX_DEPLOYMENT_TARGET "" CACHE STRING "" FORCE) # the target says it
set(CMAKE_CXX_FLAGS_INIT "-stdlib=libc++")
# libc++ is static, so that a module needs libSystem alone; no name of it leaves the module (cmake/PdExternal.cmake).
# Every module is signed without a certificate, as Apple's processors require.
foreach(kind EXE MODULE SHARED)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT "-fuse-ld=lld -nostdlib++ -Wl,-dead_strip,-adhoc_codesign")
endforeach()
set(CMAKE_CXX_STANDARD_LIBRARIES_INIT "-lc++ -lc++abi")

set(CMAKE_FIND_ROOT_PATH ${TACTUS_SYSROOT} ${CMAKE_BINARY_DIR}/headers)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
