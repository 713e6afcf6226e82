# Box2D, as the target box2d::box2d: the system's package, or compiled here from the sources in PADR_BOX2D_SOURCE.
#
# A peer's world has the same bits as every other peer's only if no multiplication and addition are fused to one rounding. The
# system's package was compiled with the compiler's default, which fuses wherever every processor of an architecture can: not
# on x86-64, but on arm64, riscv64, ppc64el and s390x. There the sources are compiled without; tools/deps.sh gets them.
# docs/determinism.md weighs the two ways.
set(PADR_BOX2D_SOURCE "" CACHE PATH "Box2D 2.4.1's sources, to be compiled here in place of the system's package")
set(PADR_BOX2D_FUSED ON)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64|amd64)$")
  set(PADR_BOX2D_FUSED OFF)
endif()
set(box2d "${PADR_BOX2D_SOURCE}")
if(NOT box2d AND PADR_BOX2D_FUSED)
  set(box2d "${PROJECT_SOURCE_DIR}/build/box2d")
endif()
if(NOT box2d)
  set(PADR_BOX2D_ORIGIN "the system's package")
  find_package(box2d REQUIRED)
  return()
endif()
if(NOT EXISTS "${box2d}/include/box2d/box2d.h")
  message(FATAL_ERROR "No Box2D in ${box2d}: run tools/deps.sh, which puts it into build/box2d, or set PADR_BOX2D_SOURCE to a "
    "folder with the sources of Box2D 2.4.1")
endif()

set(PADR_BOX2D_ORIGIN "its sources")
set(PADR_BOX2D_LICENCE "${box2d}/LICENSE")
# Its clock is left out: common/world/box2d_timer.cpp has another.
file(GLOB sources CONFIGURE_DEPENDS "${box2d}/src/*/*.cpp")
list(FILTER sources EXCLUDE REGEX "/b2_timer[.]cpp$")
add_library(padr_box2d STATIC ${sources})
add_library(box2d::box2d ALIAS padr_box2d)
target_include_directories(padr_box2d SYSTEM PUBLIC "${box2d}/include" PRIVATE "${box2d}/src")
target_compile_options(padr_box2d PRIVATE -w)
