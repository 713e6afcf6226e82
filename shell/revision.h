#pragma once

#include <string_view>

namespace padr::shell {

/// What `git describe` said of the source when the build was configured; the version where there was no git.
std::string_view revision();
/// The project's version, such as 0.2.0.
std::string_view version();

}  // namespace padr::shell
