# Windows x64 by Debian's g++-mingw-w64-x86-64-posix. The preset `windows` names this file.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(triplet x86_64-w64-mingw32)
set(CMAKE_C_COMPILER ${triplet}-gcc-posix)
set(CMAKE_CXX_COMPILER ${triplet}-g++-posix)
set(CMAKE_RC_COMPILER ${triplet}-windres)
set(CMAKE_DLLTOOL ${triplet}-dlltool)
# Windows 10: its sockets, wide paths and UTF-8. (libstdc++ itself selects C99 number formats: 1e-05, not
# msvcrt's 1e-005.)
set(CMAKE_C_FLAGS_INIT "-D_WIN32_WINNT=0x0A00")
# GCC does not align the stack to 32 bytes on Win64 (its bug 54412): vector moves must not require it.
# -Wa,-mbig-obj: Boost's templates make more sections than the usual format can count.
set(CMAKE_CXX_FLAGS_INIT "-D_WIN32_WINNT=0x0A00 -Wa,-muse-unaligned-vector-move -Wa,-mbig-obj")
# Static runtime: libstdc++, libgcc and libwinpthread are linked into the module.
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")
set(CMAKE_MODULE_LINKER_FLAGS_INIT "-static -s")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-static")

set(CMAKE_FIND_ROOT_PATH /usr/${triplet} ${CMAKE_BINARY_DIR}/sysroot ${CMAKE_BINARY_DIR}/headers)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
# For programs that the build itself runs: Debian's wine64, which is not in PATH.
find_program(TACTUS_WINE NAMES wine64 PATHS /usr/lib/wine)
if(TACTUS_WINE)
  set(CMAKE_CROSSCOMPILING_EMULATOR env WINEPREFIX=${CMAKE_BINARY_DIR}/wine WINEDEBUG=-all DISPLAY= ${TACTUS_WINE})
endif()
