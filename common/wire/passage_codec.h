#pragma once

#include "common/sync/residents.h"
#include "common/sync/updates.h"

namespace padr::wire {

class Update;
class Transfer;

/// The passages of an update. Taking them checks what can be checked without knowing the scene: false if malformed.
void put_passages(const sync::Bundle& b, Update& out);
bool take_passages(const Update& in, sync::Bundle& out);

/// The bodies of a region, which has so many slots; 0 if the scene is no region.
void put_residents(const sync::Residents& r, Transfer& out);
bool take_residents(const Transfer& in, std::size_t slots, sync::Residents& out);

}  // namespace padr::wire
