-- The info column: what a datagram says, as a sentence.
local datagram = require("padr.datagram")

local function count(n, one, many)
  return ("%d %s"):format(n, n == 1 and one or many)
end

local function peers(list)
  local names = {}
  for n, seat in ipairs(list) do names[n] = seat.slot.v end
  return table.concat(names, ", ")
end

-- What an update tells besides avatar and bodies; nil if nothing.
local function order(update)
  if update.leave then return "leaves" end
  if update.raw.spectates.v then return "spectates" end
  if update.admission then return ("admits peer %d"):format(update.admission.slot.v) end
  if #update.removals > 0 then return "removes peer " .. peers(update.removals) end
  if update.inner then
    return ("passes on %d of peer %d"):format(update.inner.index, update.inner.peer)
  end
end

local function state(said, found)
  local s, parts, bodies, resent, orders = said.state, {}, 0, 0, {}
  for n, update in ipairs(said.updates) do
    bodies = bodies + #update.bodies
    if found.resend[n] then resent = resent + 1 end
    orders[#orders + 1] = order(update)
  end
  parts[1] = ("tick %d"):format(s.mark_tick.v)
  if #said.updates == 0 then
    parts[2] = "mark"
  else
    parts[2] = count(#said.updates, "update", "updates")
    if resent > 0 then parts[2] = parts[2] .. (" (%d again)"):format(resent) end
    if bodies > 0 then parts[#parts + 1] = count(bodies, "body", "bodies") end
    for _, each in ipairs(orders) do parts[#parts + 1] = each end
  end
  if s.check_hash.v ~= 0 then
    parts[#parts + 1] = ("confirms %d: %08x"):format(s.mark_tick.v - s.check_age.v, s.check_hash.v)
  end
  if found.lost then parts[#parts + 1] = ("%d missing before this"):format(found.lost) end
  if found.stale_mark then parts[#parts + 1] = "late" end
  if found.duplicate then parts[#parts + 1] = "duplicate" end
  if next(found.superseded) then parts[#parts + 1] = "claims what it loses" end
  return table.concat(parts, ", ")
end

local SENTENCES = {
  join = function(m) return "wants to join, " .. m.scenario.v end,
  welcome = function(m) return ("welcomes peer %d"):format(m.peer.v) end,
  redirect = function(m) return ("knows who to ask: port %d"):format(m.port.v) end,
  refuse = function(m) return "refuses: " .. m.reason.v end,
  ping = function() return "ping" end,
  pong = function() return "pong" end,
  ask = function(m) return ("asks who is near region %d"):format(m.about.v) end,
  tell = function(m)
    return ("tells who is near region %d: is in %s, knows %s"):format(m.about.v, count(#m["in"], "region", "regions"),
      count(#m.known, "peer", "peers"))
  end,
  pull = function(m) return ("asks for pieces from %d on"):format(m.from.v) end,
  piece = function(m, found)
    return ("piece %d of %d%s"):format(m.index.v + 1, m.count.v, found.transfer and ", the last one missing" or "")
  end,
  enter = function() return "asks to be let in" end,
  poll = function(m) return (m.number.v > 0 and ("question %d: "):format(m.number.v) or "") .. (m.freeze.v and "takes nothing more from the silent: peer " or "asks who hears peer ") .. peers(m.lost) end,
  answer = function(m)
    local parts = {}
    for n, seat in ipairs(m.lost) do parts[n] = ("has %d of peer %d"):format(seat.have.v, seat.slot.v) end
    return table.concat(parts, ", ")
  end,
  fetch = function(m) return ("asks for updates of peer %d from %d on"):format(m.slot.v, m.from.v) end,
  fetched = function(m, _, said)
    return ("hands over %s of peer %d"):format(count(#said.updates, "update", "updates"), m.slot.v)
  end,
  probe = function(m) return ("is incarnation %d, hears peer %s"):format(m.incarnation.v, peers(m.members)) end,
  reach = function(m) return #m.heard == 0 and "hears nobody" or "hears peer " .. peers(m.heard) end,
  newcomer = function(m) return ("a newcomer is at port %d"):format(m.port.v) end,
}

local DROPPED = {
  short = "shorter than a datagram can be", long = "longer than a datagram may be", magic = "none of ours",
  tag = "damaged: the CRC does not fit",
  malformed = "malformed", order = "updates out of order", value = "a value out of range",
}

local KINDS = datagram.KINDS

local sentence = {}

-- `said` is nil if everybody drops the datagram, and `reason` says why.
function sentence.of(envelope, said, found, reason)
  local from = envelope.peer == datagram.NOBODY and "newcomer" or "peer " .. envelope.peer
  if found.to then from = from .. " → " .. found.to end
  if envelope.handshake then return "handshake: " .. envelope.handshake end
  if envelope.seal_good == false then return ("%s: its seal fits no key in the key log"):format(from) end
  if envelope.seal == "encrypt" and not said and not reason then return ("%s: encrypted %s"):format(from, KINDS[envelope.kind]) end
  if not said then
    if reason == "version" then return ("%s: protocol version %d"):format(from, envelope.version) end
    if reason == "kind" then return ("%s: kind %d, which is none"):format(from, envelope.kind) end
    return ("%s: %s"):format(from, DROPPED[reason] or "cut off by the capture")
  end
  if said.name == "state" then return from .. ": " .. state(said, found) end
  return from .. ": " .. SENTENCES[said.name](said.message, found, said)
end

return sentence
