-- Protobuf as far as section 2 of proto/WIRE.md goes. From a Lua string to tables that know where in it each value stands,
-- so that Wireshark can show the bytes of what is selected. Needs nothing of Wireshark's but Struct.
local protobuf = {}

local DEEPEST = 100 -- messages within messages, as in every protobuf library
local VARINT, EIGHT, BYTES, GROUP, END_OF_GROUP, FOUR = 0, 1, 2, 3, 4, 5

-- Raised by everything that decodes; `padr.datagram` catches it. `reason` is one of WIRE.md's words.
function protobuf.drop(reason, detail)
  error({ reason = reason, detail = detail }, 0)
end

function protobuf.require(condition, detail)
  if not condition then protobuf.drop("malformed", detail) end
end

local malformed_unless = protobuf.require

-- The varint at a position: its lower 32 bits, the position behind it, and whether any bit at all is set.
local function varint(data, at, stop, longest)
  local value, scale, any = 0, 1, false
  for n = 1, longest do
    malformed_unless(at < stop, "a varint is cut off")
    local byte = data:byte(at)
    at = at + 1
    local bits = byte % 128
    if bits > 0 then any = true end
    if n <= 5 then value = value + bits * scale end
    scale = scale * 128
    if byte < 128 then return value % 4294967296, at, any end
  end
  protobuf.drop("malformed", "a varint is too long")
end

local function zigzag(value)
  return value % 2 == 0 and value / 2 or -(value + 1) / 2
end

local function unpack_at(format)
  return function(data, at) return (Struct.unpack(format, data, at)) end
end

local read_fixed32, read_float = unpack_at("<I4"), unpack_at("<f")

-- By type of a field: wire type, value if absent, and what makes a value of what was found. 64-bit numbers are kept as their
-- eight bytes: Lua 5.2 has nothing better, and Wireshark reads them itself.
local SCALARS = {
  uint32 = { wire = VARINT, default = 0, read = function(found) return found.value end },
  sint32 = { wire = VARINT, default = 0, read = function(found) return zigzag(found.value) end },
  bool = { wire = VARINT, default = false, read = function(found) return found.any end },
  fixed32 = { wire = FOUR, default = 0, read = function(found, data) return read_fixed32(data, found.at) end },
  fixed64 = { wire = EIGHT, default = ("\0"):rep(8), read = function(found, data) return data:sub(found.at, found.at + 7) end },
  bytes = { wire = BYTES, default = "", read = function(found, data) return data:sub(found.at, found.stop - 1) end },
  text = {
    wire = BYTES, default = "",
    read = function(found, data) return (data:sub(found.at, found.stop - 1):gsub("[^ -~]", "?")) end,
  },
}
SCALARS.sfixed64 = SCALARS.fixed64

-- Repeated numbers: the wire type that each has without packing, and how one is read.
local COLUMNS = {
  uint32s = {
    wire = VARINT,
    read = function(data, at, stop) return varint(data, at, stop, 10) end,
  },
  sint32s = {
    wire = VARINT,
    read = function(data, at, stop)
      local value, behind = varint(data, at, stop, 10)
      return zigzag(value), behind
    end,
  },
  floats = { wire = FOUR, size = 4, read = function(data, at) return read_float(data, at), at + 4 end },
  fixed64s = { wire = EIGHT, size = 8, read = function(data, at) return data:sub(at, at + 7), at + 8 end },
  fixed32s = { wire = FOUR, size = 4, read = function(data, at) return read_fixed32(data, at), at + 4 end },
}

-- Calls `each` with what every field of the message is: number, wire, at and stop (of the content), value and any of varints.
-- Groups are left out.
local function fields(data, at, stop, each)
  local groups = {}
  while at < stop do
    local key, behind = varint(data, at, stop, 5)
    local wire, found = key % 8, { from = at, at = behind }
    found.number = (key - wire) / 8
    at = behind
    malformed_unless(found.number ~= 0, "a field has number 0")
    if wire == GROUP then
      groups[#groups + 1] = found.number
    elseif wire == END_OF_GROUP then
      malformed_unless(table.remove(groups) == found.number, "the end of a group that has not begun")
    else
      found.wire = wire
      if wire == VARINT then
        found.value, found.stop, found.any = varint(data, at, stop, 10)
      elseif wire == BYTES then
        local length
        length, found.at = varint(data, at, stop, 5)
        found.stop = found.at + length
      elseif wire == EIGHT or wire == FOUR then
        found.stop = at + (wire == EIGHT and 8 or 4)
      else
        protobuf.drop("malformed", "wire type " .. wire)
      end
      malformed_unless(found.stop <= stop, "a field is cut off")
      at = found.stop
      if #groups == 0 then each(found) end
    end
  end
  malformed_unless(#groups == 0, "a group without an end")
end

local function append_column(column, data, found, into)
  if found.wire == BYTES then
    malformed_unless(not column.size or (found.stop - found.at) % column.size == 0, "a column is not whole")
    local at = found.at
    while at < found.stop do
      local value, behind = column.read(data, at, found.stop)
      into[#into + 1] = { v = value, at = at, stop = behind }
      at = behind
    end
  elseif found.wire == column.wire then
    into[#into + 1] = { v = column.read(data, found.at, found.stop), at = found.at, stop = found.stop }
  end
end

-- An empty message of that specification; `at` and `stop` are where it stands.
local function empty(spec, at, stop)
  local out = { _at = at, _stop = stop }
  for _, field in pairs(spec) do
    local scalar = SCALARS[field[2]]
    if scalar then
      out[field[1]] = { v = scalar.default }
    elseif not field.one then
      out[field[1]] = {}
    end
  end
  return out
end

-- The message at [at, stop) of the string by its specification, a table by field number of
--   { name, type }         a value {v, at, stop} (at and stop are nil if it is absent), or a column of such
--   { name, one = spec }   a message, nil if absent; several are taken together
--   { name, many = spec }  an array of messages
-- `into` is a message that this one continues.
function protobuf.message(data, at, stop, spec, into, depth)
  depth = depth or 0
  malformed_unless(depth <= DEEPEST, "messages lie too deep")
  local out = into or empty(spec, at, stop)
  fields(data, at, stop, function(found)
    local field = spec[found.number]
    if not field then return end
    local name, scalar = field[1], SCALARS[field[2]]
    if scalar then
      if found.wire == scalar.wire then
        out[name] = { v = scalar.read(found, data), at = found.at, stop = found.stop }
      end
    elseif COLUMNS[field[2]] then
      append_column(COLUMNS[field[2]], data, found, out[name])
    elseif found.wire == BYTES and field.one then
      out[name] = protobuf.message(data, found.at, found.stop, field.one, out[name], depth + 1)
    elseif found.wire == BYTES then
      table.insert(out[name], protobuf.message(data, found.at, found.stop, field.many, nil, depth + 1))
    end
  end)
  return out
end

-- A payload that is one of several messages, by the table of them: name, specification and message. Of several the last
-- counts, together with those like it that come right before it.
function protobuf.one_of(data, at, stop, messages)
  local last, out
  fields(data, at, stop, function(found)
    local kind = messages[found.number]
    if not kind or found.wire ~= BYTES then return end
    out = protobuf.message(data, found.at, found.stop, kind.one, found.number == last and out or nil)
    last = found.number
  end)
  malformed_unless(last, "no message")
  return messages[last][1], messages[last].one, out
end

return protobuf
