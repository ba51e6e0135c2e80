# The version and commit that a results folder's manifest records.
set(commit "unknown")
find_package(Git QUIET)
if(GIT_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} -C ${CMAKE_CURRENT_SOURCE_DIR} describe --always --dirty --abbrev=12
    OUTPUT_VARIABLE described OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
  if(NOT failed)
    set(commit ${described})
  endif()
endif()
set(MATPOINT_VERSION_SOURCE ${CMAKE_CURRENT_BINARY_DIR}/version.cpp)
file(CONFIGURE OUTPUT ${MATPOINT_VERSION_SOURCE} CONTENT
"#include \"core/version.hpp\"

namespace matpoint {

const char* version() { return \"@PROJECT_VERSION@\"; }
const char* commit() { return \"@commit@\"; }

}  // namespace matpoint
" @ONLY)
