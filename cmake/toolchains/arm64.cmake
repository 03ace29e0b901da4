# Linux on arm64 by Debian's g++-aarch64-linux-gnu. The preset `arm64` names this file.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(triplet aarch64-linux-gnu)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)

set(CMAKE_FIND_ROOT_PATH /usr/${triplet} ${CMAKE_BINARY_DIR}/sysroot ${CMAKE_BINARY_DIR}/headers)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_LIBRARY_ARCHITECTURE ${triplet})
# The emulator for programs that the build itself runs.
find_program(TACTUS_QEMU NAMES qemu-aarch64-static qemu-aarch64)
if(TACTUS_QEMU)
  set(CMAKE_CROSSCOMPILING_EMULATOR ${TACTUS_QEMU} -L /usr/${triplet})
endif()
