# SPDX-License-Identifier: Apache-2.0
# The steps of install.external_shader: install, configure, build, render.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "ended with ${status}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE}/shader -B ${WORK}/shader -G ${GENERATOR} -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} --build ${WORK}/shader)
if(NOT EXISTS ${WORK}/shader/signal.so)
  message(FATAL_ERROR "the plugin is not named signal.so")
endif()

# The installed program finds the guest's plugin by the environment, and its own image module by its place.
set(ENV{PATINA_SHADER_PATH} ${WORK}/shader)
set(program ${WORK}/prefix/bin/patina)
run(${RUN_SCENE} ${program} ${SOURCE} signal ${WORK}/render)
run(${program} -o ${WORK}/signal.png ${SOURCE}/scene.rib)
if(NOT EXISTS ${WORK}/signal.png)
  message(FATAL_ERROR "no PNG was written")
endif()
