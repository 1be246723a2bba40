# SPDX-License-Identifier: Apache-2.0
# OpenSubdiv's CPU library with the Bfr headers, as OpenSubdiv::osdCPU. Debian's own config package names a static
# library that no package ships, so the parts are looked up one by one.
include(FindPackageHandleStandardArgs)

find_path(OpenSubdivBfr_INCLUDE_DIR opensubdiv/bfr/surface.h)
find_library(OpenSubdivBfr_LIBRARY osdCPU)
if(OpenSubdivBfr_INCLUDE_DIR)
  file(STRINGS ${OpenSubdivBfr_INCLUDE_DIR}/opensubdiv/version.h _line REGEX "define OPENSUBDIV_VERSION v[0-9_]+")
  string(REGEX REPLACE ".* v([0-9]+)_([0-9]+)_([0-9]+).*" "\\1.\\2.\\3" OpenSubdivBfr_VERSION "${_line}")
endif()
find_package_handle_standard_args(OpenSubdivBfr REQUIRED_VARS OpenSubdivBfr_LIBRARY OpenSubdivBfr_INCLUDE_DIR
  VERSION_VAR OpenSubdivBfr_VERSION)
mark_as_advanced(OpenSubdivBfr_INCLUDE_DIR OpenSubdivBfr_LIBRARY)

if(OpenSubdivBfr_FOUND AND NOT TARGET OpenSubdiv::osdCPU)
  add_library(OpenSubdiv::osdCPU SHARED IMPORTED)
  set_target_properties(OpenSubdiv::osdCPU PROPERTIES IMPORTED_LOCATION ${OpenSubdivBfr_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OpenSubdivBfr_INCLUDE_DIR})
endif()
