# Run by padr_embed, see PadrEmbed.cmake, in the folder of the texts.
string(REPLACE "," ";" texts "${TEXTS}")
list(LENGTH texts count)
set(entries "")
foreach(file IN LISTS texts)
  get_filename_component(name "${file}" NAME_WLE)
  file(READ "${file}" text)
  string(APPEND entries "    {\"${name}\", R\"padr(${text})padr\"},\n")
endforeach()
file(WRITE "${OUT}" "// Made by embed.cmake; do not edit.
#include \"${HEADER}\"

#include <array>

namespace ${NAMESPACE} {
namespace ${FUNCTION}_texts {

constexpr std::array<${TYPE}, ${count}> kTexts{{
${entries}}};

}  // namespace ${FUNCTION}_texts

std::span<const ${TYPE}> ${FUNCTION}() {
  return ${FUNCTION}_texts::kTexts;
}

}  // namespace ${NAMESPACE}
")
