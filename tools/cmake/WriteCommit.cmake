# SPDX-License-Identifier: Apache-2.0
# Run at every build, as commits come without a new configuration: writes the header OUTPUT with the commit of SOURCE, when
# that has changed. Sources that are no work tree of git have none.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --abbrev=12 --exclude=*
  OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  set(commit "unknown")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#define PATINA_COMMIT \"${commit}\"\n")
