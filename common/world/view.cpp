#include "common/world/view.h"

namespace padr::world {

const std::vector<Contact>& View::contacts() const {
  if (contacts_known_) return contacts_;
  contacts_.clear();
  for (const ContactState& c : what_.contacts) {
    const EntityId second = second_of(c.key);
    if (c.touching && second < what_.entities.size()) contacts_.push_back({first_of(c.key), second});
  }
  contacts_known_ = true;
  return contacts_;
}

}  // namespace padr::world
