# optional_header(HEADER VARIABLE): whether C++ sources can include HEADER. A header that was missing is looked for
# again each time, since ./test and users install packages between two configurations of one folder; one that
# was there is not.
include(CheckIncludeFileCXX)
macro(optional_header header variable)
  if(NOT ${variable})
    unset(${variable} CACHE)
  endif()
  check_include_file_cxx(${header} ${variable})
endmacro()
