# Writes the files IN, a list, one after the other as the array kText into the header OUT, as numbers: raw strings have a limit.
set(bytes "")
foreach(file IN LISTS IN)
  file(READ "${file}" hex HEX)
  string(REGEX REPLACE "(..)" "0x\\1," hex "${hex}")
  string(APPEND bytes "${hex}")
endforeach()
file(WRITE "${OUT}" "#pragma once\ninline constexpr unsigned char kText[] = {${bytes}0};\n")
