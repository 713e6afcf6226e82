#pragma once

#include "common/model/rng.h"
#include "common/wire/seal.h"

namespace padr::test {

/// A valid input of this target, as the real encoders write it: what fuzzing begins with. Each target that has GOOD in
/// CMakeLists.txt defines its own.
wire::Bytes good_input(Rng& rng);

}  // namespace padr::test
