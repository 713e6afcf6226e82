-- From decoded tables to Wireshark's tree.
local schema = require("padr.schema")
local protobuf = require("padr.protobuf")
local updates = require("padr.updates")

-- No message has a field of a higher number; some numbers are no longer in use.
local MOST_FIELDS = 16

local Show = {}
Show.__index = Show

-- `f` is the table of ProtoFields, `labels` that of their names, `expert` that of ProtoExperts, `tvb` the whole datagram or
-- transfer, `found` what history knows of it.
function Show.new(f, labels, expert, tvb, found)
  return setmetatable({ f = f, labels = labels, expert = expert, tvb = tvb, found = found, bodies = 0 }, Show)
end

-- The bytes of something that has at and stop; nil if it has none.
function Show:range(at, stop)
  if at and stop and stop > at and stop - 1 <= self.tvb:len() then return self.tvb(at - 1, stop - at) end
end

-- Adds a value of a field; without bytes of its own it is marked as worked out.
function Show:add(tree, name, value, range)
  local field = assert(self.f[name], name)
  if range then return tree:add(field, range, value) end
  local item = tree:add(field, value)
  item:set_generated()
  return item
end

-- Bytes as they are.
function Show:raw(tree, name, range)
  return tree:add(self.f[name], range)
end

-- Adds a value {v, at, stop}. One that is absent has no bytes, and is shown with its default.
function Show:value(tree, name, value)
  local range = self:range(value.at, value.stop)
  if range then return tree:add(self.f[name], range, value.v) end
  return tree:add(self.f[name], value.v)
end

-- A float is kept as a double, which would be printed with more digits than it has.
function Show:float(tree, name, value)
  self:value(tree, name, value):set_text(("%s: %.8g"):format(self.labels[name], value.v))
end

-- The same of 64-bit numbers, which are kept as bytes.
function Show:wide(tree, name, value, signed)
  local range, low, high = self:range(value.at, value.stop), Struct.unpack("<I4I4", value.v)
  local number = signed and Int64.new(low, high) or UInt64.new(low, high)
  if range then return tree:add(self.f[name], range, number) end
  return tree:add(self.f[name], number)
end

function Show:address(tree, name, value)
  local range = self:range(value.at, value.stop)
  if range and range:len() >= 16 then tree:add(self.f[name], range(0, 16)) end
end

function Show:node(tree, name, label, at, stop)
  local range = self:range(at, stop)
  local node = range and tree:add(self.f[name], range) or tree:add(self.f[name])
  node:set_text(label)
  return node
end

-- Messages that are shown field by field. Fields not of the table below are shown as their type says.
local BY_NAME = {
  nonce = function(show, tree, _, value) show:wide(tree, "padr.nonce", value) end,
  padding = function(show, tree, name, value) show:add(tree, name, #value.v, show:range(value.at, value.stop)) end,
  address = function(show, tree, name, value) show:address(tree, name, value) end,
  bytes = function(show, tree, name, value)
    local range = show:range(value.at, value.stop)
    if range then tree:add(show.f[name], range) end
  end,
}

local function show_field(show, tree, name, field, value)
  local kind = field[2]
  if BY_NAME[field[1]] then
    BY_NAME[field[1]](show, tree, name, value)
  elseif kind == "fixed64" or kind == "sfixed64" then
    show:wide(tree, name, value, kind == "sfixed64")
  elseif kind == "floats" then
    for _, each in ipairs(value) do show:float(tree, name, each) end
  elseif kind == "uint32s" or kind == "fixed32s" then
    for _, each in ipairs(value) do show:value(tree, name, each) end
  else
    show:value(tree, name, value)
  end
end

-- One label for a seat, a member or whatever has a slot.
local function label_of(field, message, n)
  local number = message.slot or message.peer
  return number and ("%s: peer %d"):format(field, number.v) or ("%s %d"):format(field, n - 1)
end

function Show:message(tree, prefix, spec, message)
  for number = 1, MOST_FIELDS do
    local field = spec[number]
    local name = field and prefix .. "." .. field[1]
    if field and field.many then
      for n, each in ipairs(message[field[1]]) do
        self:message(self:node(tree, name, label_of(field[1], each, n), each._at, each._stop), name, field.many, each)
      end
    elseif field and not field.one then
      show_field(self, tree, name, field, message[field[1]])
    end
  end
end

function Show:avatar(tree, avatar)
  local label = ("Avatar: %s, at (%.3f, %.3f)"):format(updates.CAUSES[avatar.cause], avatar.x.v, avatar.y.v)
  local node = self:node(tree, "padr.avatar", label, avatar.x.at, (avatar.control_y or avatar.vy).stop)
  local flags = self:range(avatar.flags.at, avatar.flags.stop)
  self:add(node, "padr.avatar.flags", avatar.flags.v, flags)
  self:add(node, "padr.cause", avatar.cause, flags)
  self:add(node, "padr.avatar.model", avatar.model, flags)
  self:add(node, "padr.avatar.awake", avatar.awake, flags)
  for _, name in ipairs({ "x", "y", "vx", "vy", "control_x", "control_y" }) do
    if avatar[name] then self:float(node, "padr.avatar." .. name, avatar[name]) end
  end
end

local function body_label(body, owner)
  local text = ("Body %d: %s"):format(body.id.v, updates.CAUSES[body.cause])
  if body.hold then text = text .. ", held" end
  if body.state then
    text = text .. (", epoch %d of peer %d, at (%.3f, %.3f)"):format(body.epoch.v, owner, body.x.v, body.y.v)
    if not body.awake then text = text .. ", at rest" end
  end
  return body.release and text .. ", released" or text
end

function Show:body(tree, body, peer)
  self.bodies = self.bodies + 1
  local node = self:node(tree, "padr.body", body_label(body, peer), body.id.at, body.id.stop)
  local flags = self:range(body.flags.at, body.flags.stop)
  self:value(node, "padr.entity", body.id)
  self:add(node, "padr.body.flags", body.flags.v, flags)
  self:add(node, "padr.cause", body.cause, flags)
  self:add(node, "padr.hold", body.hold, flags)
  self:add(node, "padr.release", body.release, flags)
  self:add(node, "padr.body.state", body.state, flags)
  if not body.state then return end
  self:add(node, "padr.owner", body.release and 255 or peer)
  self:value(node, "padr.epoch", body.epoch)
  self:value(node, "padr.claim_age", body.claim_age)
  self:add(node, "padr.claimed", body.claimed)
  self:add(node, "padr.body.awake", body.awake, flags)
  for _, name in ipairs({ "x", "y", "angle", "vx", "vy", "spin" }) do
    if body[name] then self:float(node, "padr.body." .. name, body[name]) end
  end
  local better = self.found.superseded[self.bodies]
  if better then
    self:add(node, "padr.superseded", true)
    self:add(node, "padr.superseded.by", better):add_proto_expert_info(self.expert.superseded)
  end
end

local PASSAGES = { [0] = "is bound for another", "comes in", "goes out" }

function Show:orders(tree, update)
  local raw = update.raw
  local admission = raw.admission
  if admission then
    local node = self:node(tree, "padr.admission", ("Admits peer %d"):format(admission.slot.v), admission._at, admission._stop)
    self:message(node, "padr.admission", schema.update[11].one, admission)
    node:add_proto_expert_info(self.expert.admission)
  end
  for _, removal in ipairs(raw.removals) do
    local node = self:node(tree, "padr.removal", ("Removes peer %d"):format(removal.slot.v), removal._at, removal._stop)
    self:message(node, "padr.removal", schema.update[12].many, removal)
    node:add_proto_expert_info(self.expert.removal)
  end
  for _, passage in ipairs(raw.passages) do
    local label = ("Passage: body %d of region %d %s"):format(passage.number.v, passage.region.v, PASSAGES[passage.flags.v % 4])
    local node = self:node(tree, "padr.passage", label, passage._at, passage._stop)
    self:message(node, "padr.passage", schema.update[15].many, passage)
  end
  local passed_on = raw.passed_on
  if passed_on then
    local label = ("Passes on, of peer %d"):format(passed_on.slot.v)
    local node = self:node(tree, "padr.passed_on", label, passed_on._at, passed_on._stop)
    self:message(node, "padr.passed_on", schema.update[13].one, passed_on)
    self:update(node, update.inner)
  end
end

local function update_label(update)
  local what = {}
  if update.leave then what[#what + 1] = "leaves" end
  if update.raw.spectates.v then what[#what + 1] = "spectates" end
  if update.avatar then what[#what + 1] = "avatar" end
  if #update.bodies > 0 then what[#what + 1] = #update.bodies == 1 and "1 body" or #update.bodies .. " bodies" end
  if update.admission then what[#what + 1] = "admission" end
  if #update.removals > 0 then what[#what + 1] = "removal" end
  if update.inner then what[#what + 1] = "passed on" end
  if #update.raw.passages > 0 then what[#what + 1] = #update.raw.passages == 1 and "passage" or "passages" end
  if update.raw.going.v ~= 0 then what[#what + 1] = update.raw.going.v == 2 and "wants to leave" or "stays" end
  return ("Update %d of peer %d at tick %d: %s"):format(update.index, update.peer, update.tick, table.concat(what, ", "))
end

-- `first` is the frame in which it was sent before, if it was.
function Show:update(tree, update, first)
  local raw = update.raw
  local node = self:node(tree, "padr.update", update_label(update), raw._at, raw._stop)
  self:value(node, "padr.update.index_back", raw.index_back)
  self:value(node, "padr.update.tick_back", raw.tick_back)
  self:add(node, "padr.update.peer", update.peer)
  self:add(node, "padr.update.index", update.index)
  self:add(node, "padr.update.tick", update.tick)
  if update.leave then self:value(node, "padr.update.leave", raw.leave) end
  if raw.spectates.v then self:value(node, "padr.update.spectates", raw.spectates) end
  if raw.going.v ~= 0 then self:value(node, "padr.update.going", raw.going) end
  local signature = #raw.signature.v > 0 and self:range(raw.signature.at, raw.signature.stop)
  if signature then self:raw(node, "padr.update.signature", signature) end
  if update.avatar then self:avatar(node, update.avatar) end
  for _, body in ipairs(update.bodies) do self:body(node, body, update.peer) end
  self:orders(node, update)
  if first then
    self:add(node, "padr.resend", true)
    self:add(node, "padr.resend.first", first):add_proto_expert_info(self.expert.resend)
  end
end

-- The agreed world, put together of pieces; `tvb` is it alone. What cannot be read is named and left out.
function Show:transfer(tree, data)
  local ok, transfer = pcall(protobuf.message, data, 1, #data + 1, schema.transfer)
  if not ok then
    tree:add_proto_expert_info(self.expert.malformed)
    return
  end
  local node = self:node(tree, "padr.transfer", ("Transfer: the agreed world at tick %d"):format(transfer.tick.v), 1, #data + 1)
  for _, name in ipairs({ "tick", "wanted", "begin" }) do
    self:value(node, "padr.transfer." .. name, transfer[name])
  end
  self:entities(node, transfer)
  for _, field in ipairs(schema.transfer) do
    if field.many and field[1] ~= "tail" then
      self:message(node, "padr.transfer", { field }, transfer)
    elseif field[1] == "holds" then
      for _, value in ipairs(transfer.holds) do self:wide(node, "padr.transfer.holds", value) end
    end
  end
  for _, passed_on in ipairs(transfer.tail) do self:tail(node, passed_on) end
end

local ENTITY = { "x", "y", "angle", "vx", "vy", "spin", "sleep_time" }

function Show:entities(tree, transfer)
  local numbers, awake = transfer.entities, transfer.awake
  for n = 0, math.floor(#numbers / #ENTITY) - 1 do
    local first, last = numbers[#ENTITY * n + 1], numbers[#ENTITY * n + #ENTITY]
    local label = ("Entity %d at (%.3f, %.3f)"):format(n, first.v, numbers[#ENTITY * n + 2].v)
    local node = self:node(tree, "padr.transfer.entity", label, first.at, last.stop)
    for i, name in ipairs(ENTITY) do self:float(node, "padr.transfer.entity." .. name, numbers[#ENTITY * n + i]) end
    local is_awake = awake.v:byte(n + 1)
    if is_awake then
      self:add(node, "padr.transfer.entity.awake", is_awake ~= 0, self:range(awake.at + n, awake.at + n + 1))
    end
  end
end

function Show:tail(tree, passed_on)
  local node = self:node(tree, "padr.transfer.tail", ("Of peer %d"):format(passed_on.slot.v), passed_on._at, passed_on._stop)
  self:message(node, "padr.transfer.tail", schema.update[13].one, passed_on)
  local inner = passed_on.update or protobuf.message("", 1, 1, schema.update)
  local ok, update = pcall(updates.decode, inner, passed_on.slot.v, passed_on.tick.v, passed_on.index.v + 1)
  if ok then
    self:update(node, update)
  else
    node:add_proto_expert_info(self.expert.malformed)
  end
end

return Show
