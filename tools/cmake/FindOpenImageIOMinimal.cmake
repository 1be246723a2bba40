# SPDX-License-Identifier: Apache-2.0
# OpenImageIO's libraries as OpenImageIO::OpenImageIO, without the command-line tools and the OpenCV folder that
# Debian's config package insists on. Only the image module links it (renderer/film/oiio_module.cc).
include(FindPackageHandleStandardArgs)
find_package(Imath REQUIRED)
find_package(fmt REQUIRED)

find_path(OpenImageIOMinimal_INCLUDE_DIR OpenImageIO/imageio.h)
find_library(OpenImageIOMinimal_LIBRARY OpenImageIO)
find_library(OpenImageIOMinimal_UTIL_LIBRARY OpenImageIO_Util)
if(OpenImageIOMinimal_INCLUDE_DIR)
  file(STRINGS ${OpenImageIOMinimal_INCLUDE_DIR}/OpenImageIO/oiioversion.h _lines
    REGEX "define OIIO_VERSION_(MAJOR|MINOR|PATCH) +[0-9]+")
  list(TRANSFORM _lines REPLACE ".*[A-Z] +([0-9]+).*" "\\1")
  list(JOIN _lines "." OpenImageIOMinimal_VERSION)
endif()
find_package_handle_standard_args(OpenImageIOMinimal
  REQUIRED_VARS OpenImageIOMinimal_LIBRARY OpenImageIOMinimal_UTIL_LIBRARY OpenImageIOMinimal_INCLUDE_DIR
  VERSION_VAR OpenImageIOMinimal_VERSION)
mark_as_advanced(OpenImageIOMinimal_INCLUDE_DIR OpenImageIOMinimal_LIBRARY OpenImageIOMinimal_UTIL_LIBRARY)

if(OpenImageIOMinimal_FOUND AND NOT TARGET OpenImageIO::OpenImageIO)
  add_library(OpenImageIO::OpenImageIO SHARED IMPORTED)
  set_target_properties(OpenImageIO::OpenImageIO PROPERTIES IMPORTED_LOCATION ${OpenImageIOMinimal_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OpenImageIOMinimal_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES "${OpenImageIOMinimal_UTIL_LIBRARY};Imath::Imath;fmt::fmt")
endif()
