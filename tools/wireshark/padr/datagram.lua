-- One datagram by itself: from its bytes to tables, or to the reason for which everybody drops it (proto/WIRE.md).
local protobuf = require("padr.protobuf")
local schema = require("padr.schema")
local updates = require("padr.updates")

local datagram = {}

datagram.MAGIC = 0x5064
datagram.VERSION = 9
datagram.KINDS = { [0] = "state", "session", "membership", "carried" }
datagram.CARRIED = 3 -- only ever sealed: another sealed datagram behind a short id
datagram.HEADER, datagram.TAG = 6, 4
datagram.SHORTEST, datagram.LONGEST = 10, 1200
-- The same of a sealed one, and the size of a handshake (section 14).
datagram.SEALED_HEADER, datagram.SEALED_TAG = 14, 16
datagram.SHORTEST_SEALED, datagram.LONGEST_SEALED, datagram.LONGEST_CARRIED, datagram.HANDSHAKE = 30, 1220, 1254, 76
datagram.SEALS = { "auth", "encrypt" }
datagram.HANDSHAKES = { "hello", "cookie", "introduction", "acceptance", "rekey" }
datagram.NOBODY = 255

local require_that = protobuf.require

local CRC = {}
for n = 0, 255 do
  local c = n
  for _ = 1, 8 do c = c % 2 == 1 and bit.bxor(bit.rshift(c, 1), 0xEDB88320) or bit.rshift(c, 1) end
  CRC[n] = c
end

-- CRC-32/ISO-HDLC of the first `size` bytes.
function datagram.crc(data, size)
  local crc, bxor, rshift, byte = -1, bit.bxor, bit.rshift, string.byte
  for at = 1, size do crc = bxor(CRC[bxor(crc, byte(data, at)) % 256], rshift(crc, 8)) end
  return bit.bnot(crc) % 4294967296
end

-- What is not as section 1 has it may be as section 14 has it.
local function note_seal(out, data, size)
  local mode, kind = math.floor(out.kind / 4), out.kind % 4
  if out.kind == 3 and size == datagram.HANDSHAKE and datagram.HANDSHAKES[out.peer] then
    out.handshake, out.tag, out.tag_good = datagram.HANDSHAKES[out.peer], nil, nil
  elseif datagram.SEALS[mode] and size >= datagram.SHORTEST_SEALED
    and size <= (kind == datagram.CARRIED and datagram.LONGEST_CARRIED or datagram.LONGEST_SEALED) then
    out.seal, out.kind, out.tag, out.tag_good = datagram.SEALS[mode], kind, nil, nil
    out.header_size, out.tag_size = datagram.SEALED_HEADER, datagram.SEALED_TAG
    if #data >= datagram.SEALED_HEADER then out.seal_id, out.seal_number = Struct.unpack("<I4I4", data, datagram.HEADER + 1) end
  end
end

-- The header and the tag of at least a header's bytes. `size` is that of the datagram on the wire: what a capture cut
-- off is missing in `data`, and then there is neither tag nor tag_good.
function datagram.envelope(data, size)
  local b0, b1, b2, peer, low, high = data:byte(1, 6)
  local out = {
    magic = 256 * b0 + b1, version = math.floor(b2 / 16), kind = b2 % 16, peer = peer, session = low + 256 * high,
    whole = #data == size,
  }
  if out.whole and size >= datagram.SHORTEST then
    out.tag = Struct.unpack("<I4", data, size - datagram.TAG + 1)
    out.tag_good = out.tag == datagram.crc(data, size - datagram.TAG)
  end
  out.header_size, out.tag_size = datagram.HEADER, datagram.TAG
  if not out.tag_good and out.magic == datagram.MAGIC and out.version == datagram.VERSION then note_seal(out, data, size) end
  return out
end

-- The reason of section 1 for which it is dropped, if any.
function datagram.envelope_drop(envelope, size)
  if envelope.seal or envelope.handshake then return end
  if size < datagram.SHORTEST then return "short" end
  if size > datagram.LONGEST then return "long" end
  if envelope.magic ~= datagram.MAGIC then return "magic" end
  if envelope.tag_good == false then return "tag" end
  if envelope.version ~= datagram.VERSION then return "version" end
  if not datagram.KINDS[envelope.kind] or envelope.kind == datagram.CARRIED then return "kind" end
end

local function decode_updates(list, peer, mark_tick, mark_count)
  local out = {}
  for n, raw in ipairs(list) do out[n] = updates.decode(raw, peer, mark_tick, mark_count) end
  return out
end

local function decode_state(data, at, stop, sender)
  local state = protobuf.message(data, at, stop, schema.state)
  require_that(#state.link <= #schema.link, "too many numbers of the link")
  for n, name in ipairs(schema.link) do state[name] = state.link[n] or { v = 0 } end
  require_that(state.seq.v > 0, "seq 0")
  require_that(state.mark_tick.v <= updates.MOST_TICK, "mark_tick beyond the last")
  require_that(state.loss.v <= 100, "loss above 100 per cent")
  require_that(state.check_age.v <= state.mark_tick.v, "a hash of before the start")
  local list = decode_updates(state.updates, sender, state.mark_tick.v, state.mark_count.v)
  -- Only now: what is malformed anywhere comes first.
  for n, update in ipairs(list) do
    local before = list[n - 1]
    if before and (update.index <= before.index or update.tick <= before.tick) then
      protobuf.drop("order", "updates do not ascend")
    end
    updates.check_values(update, sender)
  end
  return { name = "state", state = state, updates = list }
end

-- A signed 64-bit number, as its bytes, is a clock: within 2^53 either way.
local function require_clock(value)
  local low, high = Struct.unpack("<I4i4", value.v)
  require_that(high < 2097152 and high >= -2097152 or high == 2097152 and low == 0, "a clock beyond 2^53")
end

local function require_regions(m)
  for _, column in ipairs({ m["in"], m.seeks }) do
    require_that(#column <= 8, "too many regions")
    for _, region in ipairs(column) do require_that(region.v ~= 0, "a region that is none") end
  end
end

local function require_finding(m)
  require_that(m.nonce.v ~= ("\0"):rep(8) and m.about.v ~= 0, "about nothing")
  require_regions(m)
end

local CHECKS = {
  welcome = function(m)
    require_that(m.slots.v >= 1 and m.slots.v <= 64 and m.wanted.v >= 1 and m.wanted.v <= m.slots.v, "slots or wanted")
    require_that(m.peer.v < m.slots.v, "a number that is none")
    require_that(m.incarnation.v > 0 and m.cookie.v ~= ("\0"):rep(8), "no incarnation, or no cookie")
    require_that(m.session.v == "" or (#m.session.v == 16 and m.session.v ~= ("\0"):rep(16)), "no session's id")
  end,
  join = function(m)
    require_that(m.nonce.v ~= ("\0"):rep(8), "a join without a nonce")
    require_that(#m.scenario.v <= 128, "a long label")
  end,
  redirect = updates.require_place,
  refuse = function(m) require_that(#m.reason.v <= 400, "a long reason") end,
  ping = function(m)
    require_clock(m.sent_us)
    require_that(#m.padding.v >= 18, "a ping smaller than its pong")
  end,
  pong = function(m)
    require_clock(m.sent_us)
    require_clock(m.session_us)
  end,
  ask = require_finding,
  tell = function(m)
    require_finding(m)
    require_clock(m.clock_us)
    require_that(m.clock_us.v:byte(8) < 128, "a clock that is none")
    require_that(#m.known <= 16, "knows too many")
    for _, known in ipairs(m.known) do
      updates.require_place(known)
      require_that(#known.address.v == 16, "a key in a crowd")
      require_regions(known)
    end
  end,
}

local function decode_session(data, at, stop)
  local name, spec, message = protobuf.one_of(data, at, stop, schema.session)
  if CHECKS[name] then CHECKS[name](message) end
  return { name = name, spec = spec, message = message }
end

local function check_seats(seats, most)
  require_that(#seats >= 1 and #seats <= most, "nobody, or too many")
  for _, seat in ipairs(seats) do require_that(seat.slot.v < 64, "a slot that is none") end
  updates.require_ascending(seats, function(seat) return seat.slot.v end, "seats")
  for _, seat in ipairs(seats) do require_that(seat.heard.v <= 0x3FFF, "heard too long ago") end
end

local function check_ways(ways)
  require_that(#ways <= 64, "too many")
  for _, way in ipairs(ways) do require_that(way.slot.v < 64 and way.delay.v <= 0x3FFF, "a way that is none") end
  updates.require_ascending(ways, function(way) return way.slot.v end, "ways")
end

local function check_reach(message)
  check_ways(message.heard)
  require_that(#message.at <= 4, "too many addresses")
  for _, place in ipairs(message.at) do
    updates.require_place(place)
    require_that(#place.address.v == 16, "a key with an own address")
  end
end

local function decode_fetched(message)
  local state = message.state
  require_that(state and #state.updates > 0 and state.mark_tick.v <= updates.MOST_TICK, "nothing fetched")
  local list = decode_updates(state.updates, message.slot.v, state.mark_tick.v, state.mark_count.v)
  updates.require_ascending(list, function(update) return update.index end, "numbers")
  updates.require_ascending(list, function(update) return update.tick end, "ticks")
  return list
end

local function decode_membership(data, at, stop)
  local name, spec, m = protobuf.one_of(data, at, stop, schema.membership)
  require_that(not m.nonce or m.nonce.v ~= ("\0"):rep(8), "no nonce")
  require_that(not m.slot or m.slot.v < 64, "a slot that is none")
  if m.lost then check_seats(m.lost, 62) end
  if m.members then check_seats(m.members, 64) end
  if name == "reach" then check_reach(m) end
  if name == "newcomer" then updates.require_place(m) end
  if name == "poll" or name == "answer" then require_that(m.number.v <= 0x3FFF, "a number that is none") end
  if name == "answer" or name == "reach" then require_that(m.tick.v <= 0x7FFFFFFF, "a tick that is none") end
  local out = { name = name, spec = spec, message = m }
  if name == "pull" then
    require_that(m.from.v < 2048, "from beyond the last piece")
    require_that(m.cookie.v ~= ("\0"):rep(8), "no cookie")
  elseif name == "piece" then
    require_that(m.index.v < m.count.v and m.count.v <= 2048, "a piece that is none")
    require_that(#m.bytes.v >= 1 and #m.bytes.v <= 1150, "a piece of another size")
  elseif name == "fetched" then
    out.updates = decode_fetched(m)
  end
  return out
end

-- Whom what is carried in a readable datagram is for, by its short id, and where that begins, counted from 1; nil if nothing is.
function datagram.carried(data)
  local at = datagram.SEALED_HEADER + 1
  if #data < at + 4 + datagram.SHORTEST - 1 + datagram.SEALED_TAG then return nil end
  return Struct.unpack("<I4", data, at), at + 4
end

-- What a payload says, positions counted in the whole datagram from 1; or nil, the reason and the detail of its being
-- dropped. Anything else that goes wrong is an error of this program and is raised.
function datagram.decode(data, envelope)
  local at, stop = envelope.header_size + 1, #data - envelope.tag_size + 1
  local readers = { [0] = decode_state, decode_session, decode_membership }
  local ok, out = pcall(readers[envelope.kind], data, at, stop, envelope.peer)
  if ok then return out end
  if type(out) ~= "table" then error(out, 0) end
  return nil, out.reason, out.detail
end

return datagram
