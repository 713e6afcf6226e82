#include "common/world/view.h"

namespace padr::world {

const std::vector<Contact>& View::contacts() const {
  if (contacts_known_) return contacts_;
  contacts_.clear();
  for (const ContactState& c : what_.contacts) {
    const std::uint32_t second = c.key & 0xFFFFU;
    if (c.touching && second < what_.entities.size())
      contacts_.push_back({static_cast<EntityId>(c.key >> 16U), static_cast<EntityId>(second)});
  }
  contacts_known_ = true;
  return contacts_;
}

}  // namespace padr::world
