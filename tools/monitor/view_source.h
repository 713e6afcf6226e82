#pragma once

#include <cstdint>
#include <vector>

#include "tools/monitor/site.h"

namespace padr::monitor {

/// Where views for pages come from: the newest of each peer and kind.
class ViewSource {
 public:
  struct View {
    std::uint64_t serial = 0;
    Shared bytes;
  };

  virtual ~ViewSource() = default;
  /// Grows with every new view.
  virtual std::uint64_t serial() const = 0;
  /// Those of `views` (bits, see Subscribe) that came after `since`.
  virtual std::vector<View> views(unsigned views, std::uint64_t since) = 0;
};

}  // namespace padr::monitor
