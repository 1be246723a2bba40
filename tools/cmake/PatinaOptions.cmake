# SPDX-License-Identifier: Apache-2.0
# Compiler settings that every room shares, and the helper that declares a room.
option(PATINA_BUILD_TESTS "Build the tests" ON)
option(PATINA_WERROR "Treat warnings in own code as errors" ON)
set(PATINA_ARCH "native" CACHE STRING "Value of -march for own code; empty = the compiler's default")
set(PATINA_SANITIZE "" CACHE STRING "Value of -fsanitize, e.g. address,undefined or thread")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 11)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# The place of a program or plugin in the build tree mirrors its place after installation.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/archives)
set(PATINA_SHADER_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/patina/shaders)
set(PATINA_MODULE_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/patina/modules)
set(PATINA_SHADER_INSTALL_DIR ${CMAKE_INSTALL_LIBDIR}/patina/shaders)
set(PATINA_MODULE_INSTALL_DIR ${CMAKE_INSTALL_LIBDIR}/patina/modules)

add_library(patina_options INTERFACE)
target_compile_options(patina_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -fno-math-errno -fno-trapping-math $<$<COMPILE_LANGUAGE:CXX>:-Wnon-virtual-dtor -Woverloaded-virtual>)
# gcc 12 warns of overlap in `"text" + std::string` where there is none (gcc bug 105651).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(patina_options INTERFACE -Wno-restrict)
endif()
if(PATINA_WERROR)
  target_compile_options(patina_options INTERFACE -Werror)
endif()
if(PATINA_ARCH)
  target_compile_options(patina_options INTERFACE -march=${PATINA_ARCH})
endif()
if(PATINA_SANITIZE)
  add_compile_options(-fsanitize=${PATINA_SANITIZE} -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${PATINA_SANITIZE})
endif()

# patina_add_room(NAME SOURCES ... [LINKS ...]): the static library patina_NAME of the current folder.
function(patina_add_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;LINKS" ${ARGN})
  add_library(patina_${name} STATIC ${ROOM_SOURCES})
  target_include_directories(patina_${name} PUBLIC ${PROJECT_SOURCE_DIR})
  target_link_libraries(patina_${name} PUBLIC ${ROOM_LINKS} PRIVATE patina_options)
endfunction()
