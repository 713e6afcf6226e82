# cmake -DOUT=FILE -DNAMES=a,b,c -P embed.cmake: writes FILE, which defines embedded_link_traces() of shell/link_trace.h over
# a.link and so on of this folder.
string(REPLACE "," ";" names "${NAMES}")
list(SORT names)
list(LENGTH names count)
set(entries "")
foreach(name IN LISTS names)
  file(READ "${CMAKE_CURRENT_LIST_DIR}/${name}.link" text)
  string(APPEND entries "    {\"${name}\", R\"padr(${text})padr\"},\n")
endforeach()
file(WRITE "${OUT}" "// Made by embed.cmake; do not edit.
#include \"shell/link_trace.h\"

#include <array>

namespace padr::shell {
namespace {

constexpr std::array<EmbeddedLinkTrace, ${count}> kEmbedded{{
${entries}}};

}  // namespace

std::span<const EmbeddedLinkTrace> embedded_link_traces() {
  return kEmbedded;
}

}  // namespace padr::shell
")
