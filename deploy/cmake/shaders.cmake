# Shaders are files, embedded at build time: shaders/NAME.KIND becomes meshloop::shaders::NAME_KIND in "shaders/shaders.h".
# A line `#include "PATH"` in a shader is replaced by that file of the source tree (one level).
function(meshloop_embed_shaders target)
  file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/shaders/*.vert ${PROJECT_SOURCE_DIR}/shaders/*.frag
       ${PROJECT_SOURCE_DIR}/shaders/*.comp)
  set(view ${PROJECT_BINARY_DIR}/include/${target})
  set(header ${view}/shaders/shaders.h)
  # What they include; the build configures itself again when a shader changes, and with it its includes.
  set(included)
  foreach(file ${files})
    file(STRINGS ${file} lines REGEX "^#include \"[^\"]+\"")
    list(TRANSFORM lines REPLACE "^#include \"([^\"]+)\".*" "${PROJECT_SOURCE_DIR}/\\1")
    list(APPEND included ${lines})
  endforeach()
  list(REMOVE_DUPLICATES included)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${files})
  add_custom_command(OUTPUT ${header}
    COMMAND ${CMAKE_COMMAND} -DOUT=${header} -DROOT=${PROJECT_SOURCE_DIR} "-DFILES=${files}"
            -P ${PROJECT_SOURCE_DIR}/deploy/cmake/embed_shaders.cmake
    DEPENDS ${files} ${included} ${PROJECT_SOURCE_DIR}/deploy/cmake/embed_shaders.cmake
    COMMENT "Embedding the shaders" VERBATIM)
  add_custom_target(${target}-header DEPENDS ${header})
  add_library(${target} INTERFACE)
  add_dependencies(${target} ${target}-header)
  target_include_directories(${target} INTERFACE ${view})
endfunction()
