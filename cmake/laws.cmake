# Sources that are the same for every constitutive law: its kernels for each instruction set, and its tangents. The laws are the headers that
# src/material/laws.hpp includes, and those of MATPOINT_EXTRA_LAWS; the class of neo_hookean.hpp is NeoHookean.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS src/material/laws.hpp)
file(STRINGS src/material/laws.hpp lines REGEX "#include \"material/")
set(MATPOINT_LAWS "")
foreach(line ${lines})
  string(REGEX REPLACE ".*material/(.*)\\.hpp.*" "\\1" law "${line}")
  list(APPEND MATPOINT_LAWS ${law})
  set(MATPOINT_HEADER_OF_${law} material/${law}.hpp)
endforeach()

# `result`: the name in CamelCase.
function(matpoint_class_of law result)
  string(REPLACE "_" ";" words "${law}")
  set(class "")
  foreach(word ${words})
    string(SUBSTRING ${word} 0 1 first)
    string(SUBSTRING ${word} 1 -1 rest)
    string(TOUPPER ${first} first)
    string(APPEND class "${first}${rest}")
  endforeach()
  set(${result} ${class} PARENT_SCOPE)
endfunction()

# Laws from outside of the tree: their headers are listed in a header that src/material/laws.hpp includes.
set(includes "")
set(classes "")
foreach(header ${MATPOINT_EXTRA_LAWS})
  get_filename_component(law ${header} NAME_WE)
  if(NOT IS_ABSOLUTE ${header} OR NOT EXISTS ${header})
    message(FATAL_ERROR "MATPOINT_EXTRA_LAWS: \"${header}\" is no header with its whole path, e.g. /home/me/my_rubber.hpp with the class MyRubber")
  endif()
  if(law IN_LIST MATPOINT_LAWS)
    message(FATAL_ERROR "MATPOINT_EXTRA_LAWS: there is a law \"${law}\" already; give \"${header}\" and its class another name")
  endif()
  list(APPEND MATPOINT_LAWS ${law})
  set(MATPOINT_HEADER_OF_${law} ${header})
  matpoint_class_of(${law} class)
  list(APPEND classes ${class})
  string(APPEND includes "#include \"${header}\"\n")
endforeach()
list(JOIN classes ", " classes)
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/laws/extra_laws.hpp CONTENT "// The laws of MATPOINT_EXTRA_LAWS.
#pragma once
#include <tuple>
@includes@
namespace matpoint {
using ExtraLaws = std::tuple<@classes@>;
}
" @ONLY)
# All that see laws.hpp; nobody else is compiled anew for another list.
set_source_files_properties(src/material/registry.cpp src/material/tangent.cpp TARGET_DIRECTORY room_material
  PROPERTIES INCLUDE_DIRECTORIES ${CMAKE_CURRENT_BINARY_DIR}/laws)
set_source_files_properties(src/kernel/kernel.cpp TARGET_DIRECTORY room_kernel PROPERTIES INCLUDE_DIRECTORIES ${CMAKE_CURRENT_BINARY_DIR}/laws)

# The kernels of all laws for one instruction set, compiled with `options`.
# GNU inlines what a law calls from both of its kernels in 2D (with and without an axis) only when told so, whatever `flatten` says.
function(matpoint_law_objects set bytes options)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    list(APPEND options -finline-limit=100000)
  endif()
  set(MATPOINT_SET ${set})
  set(MATPOINT_SIMD_BYTES ${bytes})
  foreach(law ${MATPOINT_LAWS})
    set(MATPOINT_LAW_HEADER ${MATPOINT_HEADER_OF_${law}})
    matpoint_class_of(${law} MATPOINT_LAW_CLASS)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/laws/${law}_${set}.cpp)
    configure_file(src/kernel/law_kernels.cpp.in ${source} @ONLY)
    target_sources(room_kernel PRIVATE ${source})
    set_source_files_properties(${source} TARGET_DIRECTORY room_kernel PROPERTIES COMPILE_OPTIONS "${options}")
  endforeach()
endfunction()

foreach(law ${MATPOINT_LAWS})
  set(MATPOINT_LAW_HEADER ${MATPOINT_HEADER_OF_${law}})
  matpoint_class_of(${law} MATPOINT_LAW_CLASS)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/laws/${law}_tangent.cpp)
  configure_file(src/material/tangent_of_law.cpp.in ${source} @ONLY)
  target_sources(room_material PRIVATE ${source})
endforeach()
