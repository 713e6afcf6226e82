# cmake -DOUT=FILE -DNAMES=a,b,c -DPATHS=d,e -P embed.cmake, run in this folder: writes FILE, which defines embedded() of
# embedded.h over a.textproto and so on, and embedded_paths() over paths/d.csv and so on. The output holds the texts and nothing of where they came from.
string(REPLACE "," ";" names "${NAMES}")
list(SORT names)
set(entries "")
foreach(name IN LISTS names)
  file(READ "${CMAKE_CURRENT_LIST_DIR}/${name}.textproto" text)
  string(APPEND entries "    {\"${name}\", R\"padr(${text})padr\"},\n")
endforeach()
list(LENGTH names count)
string(REPLACE "," ";" paths "${PATHS}")
list(SORT paths)
set(path_entries "")
foreach(name IN LISTS paths)
  file(READ "${CMAKE_CURRENT_LIST_DIR}/paths/${name}.csv" text)
  string(APPEND path_entries "    {\"${name}\", R\"padr(${text})padr\"},\n")
endforeach()
list(LENGTH paths path_count)
set(code "// Made by embed.cmake; do not edit.
#include \"common/scenarios/embedded.h\"

#include <array>

namespace padr::scenarios {
namespace {

constexpr std::array<Embedded, ${count}> kEmbedded{{
${entries}}};

constexpr std::array<Embedded, ${path_count}> kPaths{{
${path_entries}}};

}  // namespace

std::span<const Embedded> embedded() {
  return kEmbedded;
}

std::span<const Embedded> embedded_paths() {
  return kPaths;
}

}  // namespace padr::scenarios
")
file(WRITE "${OUT}" "${code}")
