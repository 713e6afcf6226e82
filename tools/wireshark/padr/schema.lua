-- The messages of the protocol, field by field, as protobuf.lua takes them: section 3, 7, 9 and 10 of proto/WIRE.md.
local schema = {}

local admission = {
  { "slot", "uint32" }, { "incarnation", "uint32" }, { "first", "uint32" }, { "address", "bytes" }, { "port", "uint32" },
  { "have", "uint32s" },
}
local removal = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "count", "uint32" } }
local passed_on = { { "slot", "uint32" }, { "index", "uint32" }, { "tick", "uint32" } }
schema.update = {
  { "index_back", "uint32" }, { "tick_back", "uint32" }, { "avatar", "uint32" }, { "avatar_state", "floats" },
  { "body", "uint32s" }, { "body_flags", "uint32s" }, { "epoch", "uint32s" }, { "claim_age", "uint32s" },
  { "body_state", "floats" }, { "leave", "bool" }, { "admission", one = admission }, { "removals", many = removal },
  { "passed_on", one = passed_on }, { "signature", "bytes" },
}
passed_on[4] = { "update", one = schema.update }

schema.state = {
  { "seq", "uint32" }, { "mark_tick", "uint32" }, { "mark_count", "uint32" }, { "have", "uint32" },
  { "have_beyond", "fixed32" }, { "seen_seq", "uint32" }, { "seen_age", "uint32" }, { "transit", "sint32" },
  { "updates", many = schema.update }, { "check_age", "uint32" }, { "check_hash", "fixed32" }, { "loss", "uint32" },
  { "incarnation", "uint32" }, { "to_incarnation", "uint32" },
}

local member = { { "peer", "uint32" }, { "address", "bytes" }, { "port", "uint32" } }
schema.session = {
  {
    "join",
    one = {
      { "nonce", "fixed64" }, { "scene_hash", "fixed64" }, { "fingerprint", "fixed64" }, { "authority", "bool" },
      { "scenario", "text" }, { "padding", "bytes" },
    },
  },
  {
    "welcome",
    one = {
      { "nonce", "fixed64" }, { "peer", "uint32" }, { "slots", "uint32" }, { "wanted", "uint32" }, { "running", "bool" },
      { "incarnation", "uint32" },
    },
  },
  { "redirect", one = { { "nonce", "fixed64" }, { "address", "bytes" }, { "port", "uint32" } } },
  { "refuse", one = { { "nonce", "fixed64" }, { "reason", "text" } } },
  { "ping", one = { { "sent_us", "sfixed64" }, { "padding", "bytes" } } },
  { "pong", one = { { "sent_us", "sfixed64" }, { "founder_us", "sfixed64" }, { "present", "uint32" } } },
  { "start", one = { { "tick0_us", "sfixed64" }, { "member", many = member } } },
  { "ready", one = { { "round_trip_us", "uint32" }, { "started", "bool" } } },
  { "bye", one = { { "reason", "text" } } },
}

local seat = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "have", "uint32" } }
-- Of a Fetched only so much of its State counts.
local fetched_state = {
  [2] = { "mark_tick", "uint32" }, [3] = { "mark_count", "uint32" }, [9] = { "updates", many = schema.update },
}
schema.membership = {
  { "pull", one = { { "nonce", "fixed64" }, { "from", "uint32" }, { "wanted", "fixed64" } } },
  { "piece", one = { { "nonce", "fixed64" }, { "index", "uint32" }, { "count", "uint32" }, { "bytes", "bytes" } } },
  { "enter", one = { { "nonce", "fixed64" } } },
  { "poll", one = { { "lost", many = seat } } },
  { "answer", one = { { "lost", many = seat } } },
  { "fetch", one = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "from", "uint32" } } },
  { "fetched", one = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "state", one = fetched_state } } },
  {
    "probe",
    one = { { "incarnation", "uint32" }, { "members", many = seat }, { "knows_you", "bool" }, { "newest", "uint32" } },
  },
}

local contact = {
  { "key", "uint32" }, { "numbers", "floats" }, { "ids", "fixed32s" }, { "type", "uint32" }, { "touching", "bool" },
}
local avatar = {
  { "present", "bool" }, { "incarnation", "uint32" }, { "member", "bool" }, { "model", "uint32" }, { "numbers", "floats" },
  { "since", "uint32" }, { "at_rest", "bool" },
}
local authority = { { "owner", "uint32" }, { "released", "bool" }, { "epoch", "uint32" }, { "claimed", "uint32" } }
local slot = { { "first", "uint32" }, { "have", "uint32" }, { "address", "bytes" }, { "port", "uint32" } }
schema.transfer = {
  { "tick", "uint32" }, { "entities", "floats" }, { "awake", "bytes" }, { "contact", many = contact },
  { "avatar", many = avatar }, { "authority", many = authority }, { "holds", "fixed32s" }, { "slot", many = slot },
  { "tail", many = passed_on }, { "gone", many = { { "address", "bytes" }, { "port", "uint32" } } },
}

return schema
