# SPDX-License-Identifier: Apache-2.0
# OpenColorIO as OpenColorIO::OpenColorIO. Debian's config package is off the search path and names a wrong folder.
include(FindPackageHandleStandardArgs)

find_path(OpenColorIOMinimal_INCLUDE_DIR OpenColorIO/OpenColorIO.h)
find_library(OpenColorIOMinimal_LIBRARY OpenColorIO)
if(OpenColorIOMinimal_INCLUDE_DIR)
  file(STRINGS ${OpenColorIOMinimal_INCLUDE_DIR}/OpenColorIO/OpenColorABI.h _line
    REGEX "define OCIO_VERSION(_FULL_STR)? +\"")
  string(REGEX REPLACE "[^\"]*\"([0-9.]+).*" "\\1" OpenColorIOMinimal_VERSION "${_line}")
endif()
find_package_handle_standard_args(OpenColorIOMinimal
  REQUIRED_VARS OpenColorIOMinimal_LIBRARY OpenColorIOMinimal_INCLUDE_DIR VERSION_VAR OpenColorIOMinimal_VERSION)
mark_as_advanced(OpenColorIOMinimal_INCLUDE_DIR OpenColorIOMinimal_LIBRARY)

if(OpenColorIOMinimal_FOUND AND NOT TARGET OpenColorIO::OpenColorIO)
  add_library(OpenColorIO::OpenColorIO SHARED IMPORTED)
  set_target_properties(OpenColorIO::OpenColorIO PROPERTIES IMPORTED_LOCATION ${OpenColorIOMinimal_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OpenColorIOMinimal_INCLUDE_DIR})
endif()
