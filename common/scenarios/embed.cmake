# cmake -DOUT=FILE -DNAMES=a,b,c -P embed.cmake, run in this folder: writes FILE, which defines embedded() of
# embedded.h over a.textproto and so on. The output holds the texts and nothing of where they came from.
string(REPLACE "," ";" names "${NAMES}")
list(SORT names)
set(entries "")
foreach(name IN LISTS names)
  file(READ "${CMAKE_CURRENT_LIST_DIR}/${name}.textproto" text)
  string(APPEND entries "    {\"${name}\", R\"padr(${text})padr\"},\n")
endforeach()
list(LENGTH names count)
set(code "// Made by embed.cmake; do not edit.
#include \"common/scenarios/embedded.h\"

#include <array>

namespace padr::scenarios {
namespace {

constexpr std::array<Embedded, ${count}> kEmbedded{{
${entries}}};

}  // namespace

std::span<const Embedded> embedded() {
  return kEmbedded;
}

}  // namespace padr::scenarios
")
file(WRITE "${OUT}" "${code}")
