# Writes the file IN as the array kText into the header OUT, as numbers: raw strings have a limit.
file(READ "${IN}" hex HEX)
string(REGEX REPLACE "(..)" "0x\\1," bytes "${hex}")
file(WRITE "${OUT}" "#pragma once\ninline constexpr unsigned char kText[] = {${bytes}0};\n")
