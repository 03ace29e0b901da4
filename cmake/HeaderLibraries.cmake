# Header-only libraries, and libraries of which only headers are used. A cross compiler must not search the
# system's include folder, which also has headers for another system. It gets links to the needed headers in a
# folder of the build.
if(NOT CMAKE_CROSSCOMPILING)
  return()
endif()
set(header_links ${CMAKE_BINARY_DIR}/headers/include)
file(MAKE_DIRECTORY ${header_links})
foreach(library boost nlohmann libusb-1.0 hidapi doctest)
  if(EXISTS /usr/include/${library})
    file(CREATE_LINK /usr/include/${library} ${header_links}/${library} SYMBOLIC)
  endif()
endforeach()
include_directories(SYSTEM ${header_links})
set(CMAKE_REQUIRED_INCLUDES ${header_links})
if(WIN32) # Boost.Asio's sockets; a module that has none imports nothing of them
  link_libraries(ws2_32 mswsock)
  set(CMAKE_REQUIRED_LIBRARIES ws2_32 mswsock)
endif()
if(APPLE) # Boost 1.74 asks for std::result_of, which C++20 has not, unless the library is one that it knows
  add_compile_definitions(BOOST_ASIO_HAS_STD_INVOKE_RESULT)
  set(CMAKE_REQUIRED_DEFINITIONS -DBOOST_ASIO_HAS_STD_INVOKE_RESULT)
endif()
