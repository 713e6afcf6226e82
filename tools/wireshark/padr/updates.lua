-- What an update says: flags, columns and differences worked out, and checked as sections 3 and 4 of proto/WIRE.md have it.
-- Values stay tables {v, at, stop} where Wireshark is to show their bytes.
local protobuf = require("padr.protobuf")

local updates = {}

updates.CAUSES = {
  [0] = "threshold", "contact_begin", "contact_end", "proxy", "body_threshold", "at_rest", "leave",
}
updates.MODELS = { [0] = "static", "first", "second", "input" }
updates.MOST_TICK = 2147483646
updates.MOST_PEERS = 64

local MOST_BODIES, FIRST_BAD_BODY, MOST_PASSING = 27, 65535, 3
local MOST_SIGNED_BODIES, SIGNATURE, MOST_PASSAGES = 20, 64, 8
local MOST_SPEED, MOST_SPIN, MOST_ANGLE, MOST_CONTROL = 121, 95, 100000, 10000
local PLACE, MOTION, MOST_STEPS = 2 ^ -14, 2 ^ -12, 2 ^ 24 - 1
local MOST_EPOCH, MOST_NUMBER = 1073741824, 1073741823

local require_that = protobuf.require

local function require_value(condition, detail)
  if not condition then protobuf.drop("value", detail) end
end

-- Whether a bit of flags is set, by its value.
local function has(flags, bit)
  return flags % (2 * bit) >= bit
end

function updates.require_ascending(list, value_of, what)
  for n = 2, #list do
    require_that(value_of(list[n - 1]) < value_of(list[n]), what .. " do not ascend")
  end
end

function updates.require_place(message)
  local address, port = message.address.v, message.port.v
  local key = address:sub(17) -- of whoever is there, in a session with a key
  require_that(#address == 16 or #address == 48 and key ~= ("\0"):rep(32), "an address that is none")
  require_that(address:sub(1, 16) ~= ("\0"):rep(16), "an address that is none")
  require_that(port >= 1 and port <= 65535, "a port that is none")
end

-- Gives the next value of a column at every call; the second function tells whether there is one.
local function taker(column)
  local n = 0
  return function()
    n = n + 1
    require_that(column[n], "a column is too short")
    return column[n]
  end, function() return n < #column end
end

-- Likewise of the values of an update: the next, given its step, of whichever of the two columns they are told in. The second
-- function ends it: nothing is left, and they could not have been told in the other.
local function value_taker(raw)
  require_that(#raw.state == 0 or #raw.rounded == 0, "values told in two ways")
  local steps, floats_needed = #raw.rounded > 0, #raw.state == 0
  local take, more = taker(steps and raw.rounded or raw.state)
  local function take_value(step)
    local value = take()
    if not steps then
      local n = value.v / step
      local whole = math.abs(n) <= MOST_STEPS and n == math.floor(n) and (n ~= 0 or 1 / n > 0)
      floats_needed = floats_needed or not whole
      return value
    end
    require_that(math.abs(value.v) <= MOST_STEPS, "more steps than there may be")
    return { v = value.v * step, at = value.at, stop = value.stop }
  end
  return take_value, function()
    require_that(not more(), "values that belong to nothing")
    require_that(steps or floats_needed, "floats that are whole steps")
  end
end

local function avatar_of(raw, take)
  local flags = raw.avatar.v
  if flags == 0 then return nil end
  require_that(flags < 128 and has(flags, 64), "flags of an avatar")
  require_that(updates.CAUSES[flags % 8], "a cause that is none")
  local avatar = { flags = raw.avatar, cause = flags % 8, model = math.floor(flags / 8) % 4, awake = has(flags, 32) }
  avatar.x, avatar.y, avatar.vx, avatar.vy = take(PLACE), take(PLACE), take(MOTION), take(MOTION)
  local step = avatar.model == 3 and PLACE or MOTION
  if avatar.model >= 2 then avatar.control_x, avatar.control_y = take(step), take(step) end
  return avatar
end

-- `head` is the first of its numbers, `next_id` the lowest id that it may have.
local function body_of(head, next_id, take_number, take_value, tick)
  local v = head.v % 128
  local id = next_id + (head.v - v) / 128
  require_that(id < FIRST_BAD_BODY, "a body id that is none")
  require_that(updates.CAUSES[v % 8], "a cause that is none")
  local body = {
    id = { v = id, at = head.at, stop = head.stop }, flags = { v = v, at = head.at, stop = head.stop }, cause = v % 8,
    hold = has(v, 8), state = has(v, 16), release = has(v, 32), awake = has(v, 64),
  }
  require_that(body.state or not body.awake, "awake without a state")
  if not body.state then return body end
  body.epoch, body.claim_age = take_number(), take_number()
  require_that(body.claim_age.v <= tick, "a claim of before the start")
  body.claimed = tick - body.claim_age.v
  body.x, body.y, body.angle = take_value(PLACE), take_value(PLACE), take_value(PLACE)
  if body.awake then body.vx, body.vy, body.spin = take_value(MOTION), take_value(MOTION), take_value(MOTION) end
  return body
end

-- The avatar, if there is one, and the bodies, out of their columns.
local function entities_of(raw, tick, most_bodies)
  local take_number, more_numbers = taker(raw.bodies)
  local take_value, end_values = value_taker(raw)
  local avatar, bodies, next_id = avatar_of(raw, take_value), {}, 0
  while more_numbers() do
    local body = body_of(take_number(), next_id, take_number, take_value, tick)
    next_id = body.id.v + 1
    bodies[#bodies + 1] = body
  end
  require_that(#bodies <= most_bodies, "too many bodies")
  end_values()
  return avatar, bodies
end

local function check_orders(raw, depth)
  local admission, passed_on = raw.admission, raw.passed_on
  if admission then
    require_that(admission.slot.v < updates.MOST_PEERS and #admission.have <= updates.MOST_PEERS, "more slots than there may be")
    updates.require_place(admission)
  end
  for _, removal in ipairs(raw.removals) do require_that(removal.slot.v < updates.MOST_PEERS, "a slot that is none") end
  updates.require_ascending(raw.removals, function(removal) return removal.slot.v end, "removals")
  if passed_on then
    require_that(depth < MOST_PASSING, "updates that lie too deep")
    require_that(passed_on.slot.v < updates.MOST_PEERS, "a slot that is none")
    require_that(passed_on.tick.v <= updates.MOST_TICK and passed_on.index.v < 4294967295, "a tick or number that is none")
  end
end

local function count_sorts(raw)
  local function one(is) return is and 1 or 0 end
  local entities = raw.avatar.v ~= 0 or #raw.bodies > 0
  return one(raw.leave.v) + one(raw.admission) + one(#raw.removals > 0) + one(raw.passed_on) + one(entities)
    + one(#raw.passages > 0) + one(raw.going.v ~= 0) + one(raw.spectates.v)
end

-- Steps of bodies from one region to another.
local function check_passages(raw)
  require_that(raw.going.v <= 2, "neither going nor staying")
  require_that(#raw.passages <= MOST_PASSAGES, "too many passages")
  for _, passage in ipairs(raw.passages) do
    local flags, values = passage.flags.v, #passage.state
    local kind = flags % 4
    require_that(kind < 3 and flags < 4096, "a passage that is none")
    require_that(passage.number.v < 65536, "a body that is none")
    require_that(passage.crossings.v >= 1 and passage.crossings.v <= MOST_NUMBER, "a body that is none")
    require_that(kind == 1 or flags < 4 and values == 0, "a state of what does not come in")
    require_that(kind == 0 or passage.to.v == 0, "bound, and on its way")
    require_that(kind ~= 1 or values == (has(flags, 8) and 6 or 3), "a state of another length")
  end
end

-- An update of that peer, by the mark that its numbers count back from. Raises `malformed`.
function updates.decode(raw, peer, mark_tick, mark_count, depth)
  depth = depth or 0
  require_that(count_sorts(raw) <= 1, "an update of two sorts")
  require_that(raw.index_back.v < mark_count, "a number below 0")
  require_that(raw.tick_back.v <= mark_tick, "a tick before the start")
  local signature = #raw.signature.v
  require_that(signature == 0 or signature == SIGNATURE, "a signature of another length")
  check_orders(raw, depth)
  check_passages(raw)
  local update = {
    raw = raw, peer = peer, index = mark_count - 1 - raw.index_back.v, tick = mark_tick - raw.tick_back.v, leave = raw.leave.v,
    admission = raw.admission, removals = raw.removals,
  }
  update.avatar, update.bodies = entities_of(raw, update.tick, signature > 0 and MOST_SIGNED_BODIES or MOST_BODIES)
  local passed_on = raw.passed_on
  if passed_on then
    local inner = passed_on.update or protobuf.message("", 1, 1, require("padr.schema").update)
    update.passed_on = passed_on
    update.inner = updates.decode(inner, passed_on.slot.v, passed_on.tick.v, passed_on.index.v + 1, depth + 1)
  end
  return update
end

local function finite_within(value, most)
  return value.v == value.v and math.abs(value.v) <= most
end

local function check_vector(x, y, most)
  require_value(finite_within(x, math.huge) and finite_within(y, math.huge), "a number that is none")
  require_value(math.abs(x.v) ~= math.huge and math.abs(y.v) ~= math.huge, "a number that is not finite")
  require_value(not most or math.sqrt(x.v * x.v + y.v * y.v) <= most, "a vector that is too long")
end

local function check_body(body)
  require_value(body.epoch.v >= 1 and body.epoch.v <= MOST_EPOCH, "an epoch that is none")
  check_vector(body.x, body.y)
  require_value(finite_within(body.angle, MOST_ANGLE), "an angle out of range")
  if body.awake then
    check_vector(body.vx, body.vy, MOST_SPEED)
    require_value(finite_within(body.spin, MOST_SPIN), "a spin out of range")
  end
end

local function check_avatar(avatar)
  check_vector(avatar.x, avatar.y)
  check_vector(avatar.vx, avatar.vy, MOST_SPEED)
  if avatar.control_x then check_vector(avatar.control_x, avatar.control_y, MOST_CONTROL) end
  require_value(avatar.awake or (avatar.vx.v == 0 and avatar.vy.v == 0), "an avatar at rest that moves")
end

-- Section 15, but for what hangs on the session.
local function check_passage(passage)
  local kind, state = passage.flags.v % 4, passage.state
  require_value(kind ~= 0 or passage.to.v ~= 0, "bound for nowhere")
  if kind ~= 1 then return end
  check_vector(state[1], state[2])
  require_value(finite_within(state[3], MOST_ANGLE), "an angle out of range")
  if not state[4] then return end
  check_vector(state[4], state[5], MOST_SPEED)
  require_value(finite_within(state[6], MOST_SPIN), "a spin out of range")
end

-- The ranges of section 4, but for those that hang on the session or the scenario. Raises `value`.
function updates.check_values(update, sender)
  local admission, passed_on = update.admission, update.passed_on
  if admission then
    require_value(admission.slot.v ~= sender and admission.incarnation.v > 0, "an admission of oneself or nobody")
    require_value(admission.incarnation.v <= MOST_NUMBER and admission.first.v <= MOST_NUMBER, "numbers of an admission")
    for _, have in ipairs(admission.have) do require_value(have.v <= MOST_NUMBER, "numbers of an admission") end
  end
  for _, removal in ipairs(update.removals) do
    require_value(removal.slot.v ~= sender, "a removal of oneself")
    require_value(removal.incarnation.v <= MOST_NUMBER and removal.count.v <= MOST_NUMBER, "numbers of a removal")
  end
  for _, body in ipairs(update.bodies) do
    if body.state then check_body(body) end
  end
  if update.avatar then check_avatar(update.avatar) end
  for _, passage in ipairs(update.raw.passages) do check_passage(passage) end
  if passed_on then
    require_value(passed_on.slot.v ~= sender, "passes on its own")
    require_value(update.inner.index <= MOST_NUMBER and update.inner.tick <= update.tick, "passes on what is not yet")
    updates.check_values(update.inner, passed_on.slot.v)
  end
end

return updates
