-- The messages of the protocol, field by field, as protobuf.lua takes them: sections 3, 7, 9, 10 and 15 of proto/WIRE.md.
local schema = {}

local admission = {
  { "slot", "uint32" }, { "incarnation", "uint32" }, { "first", "uint32" }, { "address", "bytes" }, { "port", "uint32" },
  { "have", "uint32s" }, { "spectator", "bool" },
}
local removal = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "count", "uint32" } }
local passed_on = { { "slot", "uint32" }, { "index", "uint32" }, { "tick", "uint32" } }
local passage = {
  { "region", "uint32" }, { "number", "uint32" }, { "crossings", "uint32" }, { "flags", "uint32" }, { "state", "floats" },
  { "to", "uint32" },
}
schema.update = {
  { "index_back", "uint32" }, { "tick_back", "uint32" }, { "avatar", "uint32" }, { "bodies", "uint32s" },
  { "state", "floats" }, { "rounded", "sint32s" }, [10] = { "leave", "bool" }, [11] = { "admission", one = admission },
  [12] = { "removals", many = removal }, [13] = { "passed_on", one = passed_on }, [14] = { "signature", "bytes" },
  [15] = { "passages", many = passage }, [16] = { "going", "uint32" }, [17] = { "spectates", "bool" },
}
passed_on[4] = { "update", one = schema.update }

schema.state = {
  { "link", "uint32s" }, [8] = { "transit", "sint32" }, [9] = { "updates", many = schema.update },
  [10] = { "check_age", "uint32" }, [11] = { "check_hash", "fixed32" }, [12] = { "loss", "uint32" },
}
-- What the numbers of the column are.
schema.link = {
  "seq", "mark_tick", "mark_count", "have", "seen_seq", "seen_age", "have_beyond", "incarnation", "to_incarnation",
}

local known = { { "address", "bytes" }, { "port", "uint32" }, { "in", "fixed32s" }, { "seeks", "fixed32s" } }
schema.session = {
  {
    "join",
    one = {
      { "nonce", "fixed64" }, { "scene_hash", "fixed64" }, { "fingerprint", "fixed64" }, { "authority", "bool" },
      { "scenario", "text" }, { "padding", "bytes" }, { "spectator", "bool" },
    },
  },
  {
    "welcome",
    one = {
      { "nonce", "fixed64" }, { "peer", "uint32" }, { "slots", "uint32" }, { "wanted", "uint32" },
      [6] = { "incarnation", "uint32" }, [7] = { "cookie", "fixed64" }, [8] = { "session", "bytes" },
    },
  },
  { "redirect", one = { { "nonce", "fixed64" }, { "address", "bytes" }, { "port", "uint32" } } },
  { "refuse", one = { { "nonce", "fixed64" }, { "reason", "text" } } },
  { "ping", one = { { "sent_us", "sfixed64" }, { "padding", "bytes" } } },
  { "pong", one = { { "sent_us", "sfixed64" }, { "session_us", "sfixed64" } } },
  [10] = {
    "ask",
    one = {
      { "nonce", "fixed64" }, { "crowd", "fixed64" }, { "about", "fixed32" }, { "in", "fixed32s" }, { "seeks", "fixed32s" },
      { "rank", "fixed32" }, { "padding", "bytes" },
    },
  },
  [11] = {
    "tell",
    one = {
      { "nonce", "fixed64" }, { "crowd", "fixed64" }, { "about", "fixed32" }, { "in", "fixed32s" }, { "seeks", "fixed32s" },
      { "rank", "fixed32" }, { "clock_us", "sfixed64" }, { "known", many = known }, { "noted", "bool" },
    },
  },
}

local seat = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "have", "uint32" }, { "heard", "uint32" } }
local told = {
  [2] = { "mark_tick", "uint32" }, [3] = { "mark_count", "uint32" }, [9] = { "updates", many = schema.update },
}
schema.membership = {
  {
    "pull",
    one = { { "nonce", "fixed64" }, { "from", "uint32" }, { "wanted", "fixed64" }, { "cookie", "fixed64" } },
  },
  { "piece", one = { { "nonce", "fixed64" }, { "index", "uint32" }, { "count", "uint32" }, { "bytes", "bytes" } } },
  { "enter", one = { { "nonce", "fixed64" } } },
  { "poll", one = { { "lost", many = seat }, { "freeze", "bool" }, { "number", "uint32" } } },
  { "answer", one = { { "lost", many = seat }, { "frozen", "bool" }, { "tick", "uint32" }, { "number", "uint32" } } },
  { "fetch", one = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "from", "uint32" } } },
  { "fetched", one = { { "slot", "uint32" }, { "incarnation", "uint32" }, { "state", one = told } } },
  {
    "probe",
    one = { { "incarnation", "uint32" }, { "members", many = seat }, { "knows_you", "bool" }, { "newest", "uint32" }, { "yields", "bool" } },
  },
  {
    "reach",
    one = {
      { "tick", "uint32" }, { "heard", many = { { "slot", "uint32" }, { "delay", "uint32" }, { "carried", "bool" } } },
      { "at", many = { { "address", "bytes" }, { "port", "uint32" } } },
    },
  },
  { "newcomer", one = { { "address", "bytes" }, { "port", "uint32" } } },
}

local contact = {
  { "key", "uint32" }, { "numbers", "floats" }, { "ids", "fixed32s" }, { "type", "uint32" }, { "touching", "bool" },
}
local avatar = {
  { "present", "bool" }, { "incarnation", "uint32" }, { "member", "bool" }, { "model", "uint32" }, { "numbers", "floats" },
  { "since", "uint32" }, { "at_rest", "bool" },
}
local authority = { { "owner", "uint32" }, { "released", "bool" }, { "epoch", "uint32" }, { "claimed", "uint32" } }
local slot = { { "first", "uint32" }, { "have", "uint32" }, { "address", "bytes" }, { "port", "uint32" },
  { "since", "uint32" } }
schema.transfer = {
  { "tick", "uint32" }, { "entities", "floats" }, { "awake", "bytes" }, { "contact", many = contact },
  { "avatar", many = avatar }, { "authority", many = authority }, { "holds", "fixed64s" }, { "slot", many = slot },
  { "tail", many = passed_on },
  { "gone", many = { { "address", "bytes" }, { "port", "uint32" }, { "since", "uint32" }, { "removed", "uint32" } } },
  [13] = { "wanted", "uint32" }, [14] = { "begin", "uint32" },
  [15] = {
    "proof", many = { { "key", "bytes" }, { "incarnation", "uint32" }, { "one", "bytes" }, { "other", "bytes" } },
  },
}

return schema
