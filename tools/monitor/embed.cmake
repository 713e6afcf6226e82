# cmake -DOUT=FILE -DPAGE=FOLDER -DDYGRAPHS=FOLDER -P embed.cmake: writes FILE, which defines assets() of assets.h over
# every file of PAGE but *.md, and what the page uses of dygraphs. The output holds the files and nothing of where they
# came from.
set(types_html "text/html; charset=utf-8")
set(types_css "text/css; charset=utf-8")
set(types_js "text/javascript; charset=utf-8")
set(types_mjs "text/javascript; charset=utf-8")
set(types_json "application/json")
set(types_webmanifest "application/manifest+json")
set(types_svg "image/svg+xml")
set(types_png "image/png")
set(types_ico "image/x-icon")

set(entries "")
set(count 0)
function(add_file path file)
  string(REGEX REPLACE ".*\\." "" ending "${file}")
  if(NOT DEFINED types_${ending})
    message(FATAL_ERROR "${path}: the page cannot have files that end in .${ending}")
  endif()
  file(SHA256 "${file}" hash)
  string(SUBSTRING "${hash}" 0 16 tag)
  file(SIZE "${file}" size)
  if(ending STREQUAL "png" OR ending STREQUAL "ico")
    file(READ "${file}" hex HEX)
    string(REGEX REPLACE "(..)" "\\\\x\\1" text "${hex}")
    set(literal "\"${text}\"")
  else()
    file(READ "${file}" text)
    # In parts: CMake takes long to put together what is very long, and some compilers to read it.
    set(literal "")
    string(LENGTH "${text}" length)
    set(at 0)
    while(at LESS length)
      string(SUBSTRING "${text}" ${at} 16000 part)
      string(APPEND literal "R\"padr(${part})padr\"\n")
      math(EXPR at "${at} + 16000")
    endwhile()
    if(literal STREQUAL "")
      set(literal "\"\"")
    endif()
  endif()
  string(APPEND entries "    {\"${path}\", \"${types_${ending}}\", \"\\\"${tag}\\\"\", std::string_view(${literal}, ${size})},\n")
  set(entries "${entries}" PARENT_SCOPE)
  math(EXPR count "${count} + 1")
  set(count ${count} PARENT_SCOPE)
endfunction()

file(GLOB_RECURSE files RELATIVE "${PAGE}" "${PAGE}/*")
list(SORT files)
foreach(file IN LISTS files)
  if(NOT file MATCHES "\\.md$")
    add_file("/${file}" "${PAGE}/${file}")
  endif()
endforeach()
add_file("/vendor/dygraph.css" "${DYGRAPHS}/dygraph.css")
add_file("/vendor/dygraph.min.js" "${DYGRAPHS}/dygraph.min.js")

file(WRITE "${OUT}" "// Made by embed.cmake; do not edit.
#include \"tools/monitor/assets.h\"

#include <array>

namespace padr::monitor {
namespace {

constexpr std::array<Asset, ${count}> kAssets{{
${entries}}};

}  // namespace

std::span<const Asset> assets() {
  return kAssets;
}

}  // namespace padr::monitor
")
