#pragma once

#include "common/model/rng.h"
#include "common/wire/seal.h"

namespace padr::test {

/// A valid input of this target, as the real encoders write it: what fuzzing begins with. Each target that has GOOD in
/// CMakeLists.txt defines its own.
wire::Bytes good_input(Rng& rng);
/// How many of them its plain test tries. PADR_FUZZ_GOOD_INPUTS says so in CMakeLists.txt, for targets that are slow.
#ifdef PADR_FUZZ_GOOD_INPUTS
inline constexpr int kGoodInputs = PADR_FUZZ_GOOD_INPUTS;
#else
inline constexpr int kGoodInputs = 150;
#endif

}  // namespace padr::test
