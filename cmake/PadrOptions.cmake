# Language level, warnings, sanitizers and determinism flags, the same for every target.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

option(PADR_WERROR "Treat warnings as errors" OFF)
set(PADR_SANITIZE "" CACHE STRING "Comma separated list for -fsanitize=, e.g. address,undefined")
option(PADR_COVERAGE "Instrument for gcov" OFF)
option(PADR_UNITY "Compile the files of a folder some at a time: quicker from nothing, slower after a change" OFF)
option(PADR_FUZZ "Build the libFuzzer targets (clang)" OFF)

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CCACHE_PROGRAM}")
endif()

# Asserts guard our own invariants and stay on in release; see CONTRIBUTING.md.
string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELEASE "${CMAKE_CXX_FLAGS_RELEASE}")
string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_RELWITHDEBINFO "${CMAKE_CXX_FLAGS_RELWITHDEBINFO}")

# Peers compare physics to the last bit: no fused multiply-add, no fast-math, whatever the compiler's default.
add_compile_options(-ffp-contract=off)

if(PADR_SANITIZE)
  add_compile_options(-fsanitize=${PADR_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${PADR_SANITIZE})
endif()
if(PADR_COVERAGE)
  add_compile_options(--coverage)
  add_link_options(--coverage)
endif()

# Against what a mistake of ours would let a datagram do, in optimised builds without sanitizers, which have their own.
# None of it changes a float. tests/architecture looks whether it is in the programs.
option(PADR_HARDEN "Hardening flags of compiler and linker, in optimised builds" ${PROJECT_IS_TOP_LEVEL})
set(PADR_HARDENED OFF)
if(PADR_HARDEN AND NOT PADR_SANITIZE AND NOT PADR_COVERAGE AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug"
   AND CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
  set(PADR_HARDENED ON)
  add_compile_options(-fPIE -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=2 -D_GLIBCXX_ASSERTIONS -fstack-protector-strong
    -fstack-clash-protection)
  if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|i[3-6]86")
    add_compile_options(-fcf-protection)
  endif()
  add_link_options(-pie LINKER:-z,relro,-z,now,-z,noexecstack)
endif()

# Generated code and third-party headers are not held to these.
function(padr_warnings target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion
    -Wnon-virtual-dtor -Woverloaded-virtual -Wold-style-cast -Wcast-qual)
  if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    target_compile_options(${target} PRIVATE -Wreserved-identifier)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # g++ 12 sees overlapping copies where a literal is joined to a temporary string (GCC bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
    # It takes what several files are put together from for headers, in which local types would be a mistake.
    if(PADR_UNITY)
      target_compile_options(${target} PRIVATE -Wno-subobject-linkage)
    endif()
  endif()
  if(PADR_WERROR)
    target_compile_options(${target} PRIVATE -Werror)
  endif()
endfunction()

# Reading headers is most of compiling here, so with PADR_UNITY several files of a target become one. Not CMake's own unity
# build: its files include by absolute path, and a compiler cache could not know those of another checkout again.
function(padr_unity target)
  set(at_once 8)
  if(NOT PADR_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  set(text "")
  set(count 0)
  set(files "")
  foreach(source IN LISTS sources)
    get_filename_component(file "${source}" ABSOLUTE BASE_DIR "${CMAKE_CURRENT_SOURCE_DIR}")
    string(FIND "${file}" "${CMAKE_BINARY_DIR}/" made_here)
    if(made_here EQUAL 0 OR NOT file MATCHES "[.]cpp$")
      continue()
    endif()
    file(RELATIVE_PATH name "${PROJECT_SOURCE_DIR}" "${file}")
    set_source_files_properties("${source}" PROPERTIES HEADER_FILE_ONLY ON)
    string(APPEND text "#include \"${name}\"\n")
    math(EXPR count "${count} + 1")
    math(EXPR left "${count} % ${at_once}")
    if(left EQUAL 0)
      list(APPEND files "${text}")
      set(text "")
    endif()
  endforeach()
  if(text)
    list(APPEND files "${text}")
  endif()
  set(number 0)
  foreach(text IN LISTS files)
    set(file "${CMAKE_CURRENT_BINARY_DIR}/${target}_${number}.cpp")
    file(CONFIGURE OUTPUT "${file}" CONTENT "${text}" @ONLY)
    target_sources(${target} PRIVATE "${file}")
    math(EXPR number "${number} + 1")
  endforeach()
endfunction()

# Optimising is half of compiling here. In a folder that sets PADR_OPTIMISE_LITTLE are tests, command lines, texts and pages:
# their own processor time is small beside that of what they call. No float depends on it, see above. With sanitizers it is
# two thirds of compiling: there these folders are not optimised at all.
set(PADR_OPTIMISE_LITTLE OFF)
function(padr_optimise target)
  if(PADR_OPTIMISE_LITTLE AND PADR_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  elseif(PADR_OPTIMISE_LITTLE AND CMAKE_BUILD_TYPE STREQUAL "Release")
    target_compile_options(${target} PRIVATE -O1)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU") # it guesses where little is inlined; clang and the preset dev look for these
      target_compile_options(${target} PRIVATE -Wno-maybe-uninitialized)
    endif()
  endif()
endfunction()

# What each target of ours calls once it has its sources.
function(padr_ours target)
  padr_warnings(${target})
  padr_unity(${target})
  padr_optimise(${target})
endfunction()

# A static library of the pure core; includes are written from the repository root.
function(padr_core_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_include_directories(${name} PUBLIC "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PUBLIC ${ARG_LINKS})
  padr_ours(${name})
  set_property(GLOBAL APPEND PROPERTY PADR_CORE_LIBRARIES ${name})
endfunction()

# A program of ours under bin/.
function(padr_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_link_libraries(${name} PRIVATE ${ARG_LINKS})
  padr_ours(${name})
endfunction()
