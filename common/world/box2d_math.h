#pragma once

namespace padr::world {

/// Does nothing but make the linker take the definitions of the .cpp, in place of the C library's.
void take_portable_math();

}  // namespace padr::world
