# What include paths cannot forbid: vendor headers outside their room, applications seen from common or from each
# other, and paths that climb out of a room. Runs at configure time; `cmake -DROOT=DIR -P layering.cmake` runs it alone.

# "regular expression of the header|regular expression of the files that may include it"
set(MESHLOOP_VENDOR_ROOMS
  "^draco/|^common/codec/"
  "^dds/|^common/transport/"
  "^(EGL|GLES[23]*|KHR)/|^(common/gpu|device/draw)/"
  "^(spng|turbojpeg|tiffio)|^common/image/"
  "^meshoptimizer|^(common/detail|server/adjust)/"
  "^(polyclipping/|clipper[.]hpp)|^server/adjust/"
  "^(ceres|glog)/|^server/adjust/"
  "^assimp/|^common/interchange/"
  "^expat|^common/interchange/"
  "[.]hxx$|^common/interchange/step_reader[.]cpp$"
  "^yaml-cpp/|^common/(recording|implicit)/"
  "^sqlite3|^server/store/"
  "^OpenNI|^server/capture/"
  "^libfreenect|^server/capture/"
  "^(SDL|imgui)|^server/console/"
  "^(wayland-|X11/|xf86drm|gbm)|^device/draw/"
  "^libcamera/|^device/capture/"
  "^linux/videodev2|^device/capture/"
  "^sodium|^common/base/")

function(check_includes_of root file result)
  set(found "")
  file(RELATIVE_PATH name ${root} ${file})
  file(STRINGS ${file} lines REGEX "^[ \t]*#[ \t]*include")
  foreach(line ${lines})
    string(REGEX REPLACE ".*include[ \t]*[<\"]([^>\"]+)[>\"].*" "\\1" header "${line}")
    if(header MATCHES "^\\.\\.?/")
      list(APPEND found "${name}: '${header}': name the header from the root of the tree")
    endif()
    if(name MATCHES "^common/" AND header MATCHES "^(server|device)/")
      list(APPEND found "${name}: '${header}': common knows neither application")
    endif()
    if((name MATCHES "^server/" AND header MATCHES "^device/") OR (name MATCHES "^device/" AND header MATCHES "^server/"))
      list(APPEND found "${name}: '${header}': server and device never see each other")
    endif()
    if(name MATCHES "^common/.*\\.h$" AND header MATCHES "^opencv2/")
      list(APPEND found "${name}: '${header}': no header of common shows OpenCV")
    endif()
    foreach(rule ${MESHLOOP_VENDOR_ROOMS})
      string(REGEX REPLACE "^(.*)\\|(\\^.*)$" "\\1" vendor "${rule}")
      string(REGEX REPLACE "^(.*)\\|(\\^.*)$" "\\2" rooms "${rule}")
      if(header MATCHES "${vendor}" AND NOT name MATCHES "${rooms}")
        list(APPEND found "${name}: '${header}': this vendor's headers stay in ${rooms}")
      endif()
    endforeach()
  endforeach()
  set(${result} "${${result}}" ${found} PARENT_SCOPE)
endfunction()

function(check_layering)
  set(root ${PROJECT_SOURCE_DIR})
  if(ROOT)
    set(root ${ROOT})
  endif()
  file(GLOB_RECURSE files ${root}/common/*.h ${root}/common/*.cpp ${root}/server/*.h ${root}/server/*.cpp
       ${root}/device/*.h ${root}/device/*.cpp)
  set(found_errors "")
  foreach(file ${files})
    check_includes_of(${root} ${file} found_errors)
  endforeach()
  list(REMOVE_ITEM found_errors "")
  if(found_errors)
    list(JOIN found_errors "\n  " text)
    message(FATAL_ERROR "Layering (see CONTRIBUTING.md, 'The walls'):\n  ${text}")
  endif()
endfunction()

if(CMAKE_SCRIPT_MODE_FILE AND ROOT)
  check_layering()
endif()
