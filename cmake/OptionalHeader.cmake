# optional_header(HEADER VARIABLE): whether C++ sources can include HEADER. A header that was missing is
# searched for again at every configuration, since ./test and users install packages in between; a header that
# was found is not.
include(CheckIncludeFileCXX)
macro(optional_header header variable)
  if(NOT ${variable})
    unset(${variable} CACHE)
  endif()
  check_include_file_cxx(${header} ${variable})
endmacro()
