# Compiler options for every file of tactus. docs/architecture.md, "Numbers", has the reasons.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

add_compile_options(-Wall -Wextra -Wpedantic -Wconversion -Wshadow)
# Warnings are errors with the compilers of Debian 12, which check every change; newer ones may have new
# warnings.
if((CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
   OR (CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 15))
  add_compile_options(-Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options(-Wno-restrict)  # g++ 12 warns falsely of std::string's operator+ (GCC bug 105651)
endif()
# Never -ffast-math: one module linked with it changes the floating-point mode of the whole host.
# No contraction: compilers round alike, but where core/CMakeLists.txt allows it to files of newer
# instructions. C libraries differ all the same (docs/cross_build.md).
add_compile_options(-ffp-contract=off -fno-math-errno -fno-trapping-math)
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_C_FLAGS_RELEASE "-O2 -DNDEBUG")

if(TACTUS_SANITIZE)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "TACTUS_SANITIZE: the compiler is ${CMAKE_CXX_COMPILER_ID}: expected clang; the preset sanitize chooses it")
  endif()
  add_compile_options(-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer -g1)
  if(CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 17)
    # Clang 17 and newer also check C functions. Pd and Max call every method by a pointer of one type.
    add_compile_options(-fno-sanitize=function)
  endif()
  add_link_options(-fsanitize=address,undefined)
  # [[gnu::flatten]] and [[gnu::always_inline]] multiply the code that sanitizers instrument: half a minute a file.
  add_compile_options(-Dflatten=unused -Dalways_inline=unused)
endif()
find_program(CCACHE ccache)
if(CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
endif()
