# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` adds to the programs, plugins and modules: the shader headers, the package Patina, the guide and
# its examples.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/Patina)

install(TARGETS patina_shaderapi EXPORT PatinaTargets)
set_target_properties(patina_shaderapi PROPERTIES EXPORT_NAME shaderapi)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/shaderapi/patina DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  FILES_MATCHING PATTERN "*.h")
install(EXPORT PatinaTargets NAMESPACE Patina:: DESTINATION ${package_dir})

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/PatinaConfig.cmake.in
  ${CMAKE_BINARY_DIR}/PatinaConfig.cmake INSTALL_DESTINATION ${package_dir} PATH_VARS PATINA_SHADER_INSTALL_DIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/PatinaConfigVersion.cmake COMPATIBILITY SameMinorVersion
  ARCH_INDEPENDENT)
install(FILES ${CMAKE_BINARY_DIR}/PatinaConfig.cmake ${CMAKE_BINARY_DIR}/PatinaConfigVersion.cmake
  ${CMAKE_CURRENT_LIST_DIR}/PatinaShader.cmake DESTINATION ${package_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES ${PROJECT_SOURCE_DIR}/shaderapi/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR}/shaderapi)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/shaderapi/examples DESTINATION ${CMAKE_INSTALL_DOCDIR}/shaderapi)
