# Compiler settings that hold for every target of the project.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

add_library(meshloop_settings INTERFACE)
target_compile_options(meshloop_settings INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror
  # GCC 12 guesses wrongly about inlined code of Eigen, OpenCV and std::string at high optimisation.
  $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-array-bounds -Wno-stringop-overflow -Wno-stringop-overread -Wno-restrict>)
target_compile_definitions(meshloop_settings INTERFACE MESHLOOP_VERSION="${PROJECT_VERSION}")
# Sections that nothing uses are dropped, and libraries that nothing needs are not linked.
target_link_options(meshloop_settings INTERFACE -Wl,--as-needed -Wl,--gc-sections)

set(MESHLOOP_SANITIZE "" CACHE STRING "Sanitizers, as in -fsanitize=: address,undefined or thread")
if(MESHLOOP_SANITIZE)
  add_compile_options(-fsanitize=${MESHLOOP_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${MESHLOOP_SANITIZE})
  if(MESHLOOP_SANITIZE MATCHES "undefined")
    # A quarter of the time to compile. The address sanitizer sees what the first would; classes are not cast downwards.
    add_compile_options(-fno-sanitize=object-size,vptr)
  endif()
endif()

if(MESHLOOP_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "MESHLOOP_FUZZ needs clang, as in the preset asan")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(tl-expected REQUIRED)
find_package(Threads REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(OpenCV REQUIRED COMPONENTS core imgproc video calib3d aruco)
