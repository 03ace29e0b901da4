# Linux on 32-bit processors, by Debian's g++-i686-linux-gnu: size_t has the 32 bits that it has in a browser. Only the
# unit tests of core and files are built; being static they run here as they are. The preset `i686` names this file.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR i686)
set(triplet i686-linux-gnu)
set(CMAKE_C_COMPILER ${triplet}-gcc)
set(CMAKE_CXX_COMPILER ${triplet}-g++)
# Doubles as wide as everywhere else, not the 80 bits of the old registers. g++ 12 warns falsely of std::sort over a
# small array.
set(CMAKE_CXX_FLAGS_INIT "-msse2 -mfpmath=sse -Wno-array-bounds")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-static")

set(CMAKE_FIND_ROOT_PATH /usr/${triplet} ${CMAKE_BINARY_DIR}/headers)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_CROSSCOMPILING_EMULATOR "") # none is needed
