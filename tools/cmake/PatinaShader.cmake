# SPDX-License-Identifier: Apache-2.0
# patina_add_shader(NAME SOURCE...): the shader plugin NAME.so, from C++ or C. The same function builds Patina's own plugins
# and, by find_package(Patina), those of other projects.
function(patina_add_shader name)
  cmake_parse_arguments(SHADER "" "" "SOURCES" ${ARGN})
  add_library(${name} MODULE ${SHADER_SOURCES} ${SHADER_UNPARSED_ARGUMENTS})
  set_target_properties(${name} PROPERTIES PREFIX "" C_EXTENSIONS OFF CXX_EXTENSIONS OFF
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if("CXX" IN_LIST languages)
    target_compile_features(${name} PRIVATE cxx_std_20)
  endif()
  if("C" IN_LIST languages)
    target_compile_features(${name} PRIVATE c_std_11)
  endif()
  # What lets loops over points become vector code without -ffast-math, which would change the host's float modes.
  target_compile_options(${name} PRIVATE -fno-math-errno -fno-trapping-math)
  target_link_libraries(${name} PRIVATE Patina::shaderapi)
  if(PATINA_SHADER_OUTPUT_DIRECTORY)
    target_link_libraries(${name} PRIVATE patina_options)
    set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PATINA_SHADER_OUTPUT_DIRECTORY})
    install(TARGETS ${name} LIBRARY DESTINATION ${PATINA_SHADER_INSTALL_DIR})
  endif()
endfunction()
