-- What sealed datagrams hide, and whether their tags are right, given what padr-peer --keylog has written: XChaCha20-Poly1305
-- (draft-irtf-cfrg-xchacha-03, RFC 8439) as section 14 of proto/WIRE.md uses it. No cipher of Wireshark's own is within reach of Lua.
local datagram = require("padr.datagram")

local seal = {}

local bxor, rol, band = bit.bxor, bit.rol, bit.band
local unpack, concat, char = table.unpack or unpack, table.concat, string.char
local CONSTANTS = { 0x61707865, 0x3320646E, 0x79622D32, 0x6B206574 }

-- The four words that a quarter round mixes: columns, then diagonals.
local QUARTERS = {
  { 1, 5, 9, 13 }, { 2, 6, 10, 14 }, { 3, 7, 11, 15 }, { 4, 8, 12, 16 },
  { 1, 6, 11, 16 }, { 2, 7, 12, 13 }, { 3, 8, 9, 14 }, { 4, 5, 10, 15 },
}

-- The permutation of ChaCha20 on sixteen words, in place. Sums stay far below 2^53; bit operations take them modulo 2^32.
local function permute(w)
  for _ = 1, 10 do
    for _, q in ipairs(QUARTERS) do
      local ia, ib, ic, id = q[1], q[2], q[3], q[4]
      local a, b, c, d = w[ia], w[ib], w[ic], w[id]
      a = band(a + b, -1); d = rol(bxor(d, a), 16)
      c = band(c + d, -1); b = rol(bxor(b, c), 12)
      a = band(a + b, -1); d = rol(bxor(d, a), 8)
      c = band(c + d, -1); b = rol(bxor(b, c), 7)
      w[ia], w[ib], w[ic], w[id] = a, b, c, d
    end
  end
end

local function words(bytes)
  local out = { Struct.unpack("<" .. ("I4"):rep(#bytes / 4), bytes) }
  out[#out] = nil -- where it has ended
  return out
end

local function bytes_of(numbers, count)
  local out = {}
  for n = 1, count do out[n] = Struct.pack("<I4", numbers[n] % 4294967296) end
  return concat(out)
end

local function state_of(key, last)
  local s = { unpack(CONSTANTS) }
  for n, word in ipairs(words(key)) do s[4 + n] = word end
  for n = 1, 4 do s[12 + n] = last[n] end
  return s
end

local function block(key, counter, nonce)
  local before = state_of(key, { counter, nonce[1], nonce[2], nonce[3] })
  local after = { unpack(before) }
  permute(after)
  for n = 1, 16 do after[n] = after[n] + before[n] end
  return bytes_of(after, 16)
end

-- The key and the nonce of RFC 8439 for a number, `low` and `high` its halves: section 14's nonce is the number and zeros.
local function inner(key, low, high)
  local w = state_of(key, { low, high, 0, 0 })
  permute(w)
  return bytes_of({ w[1], w[2], w[3], w[4], w[13], w[14], w[15], w[16] }, 8), { 0, 0, 0 }
end

local function hide(key, nonce, text)
  local out = {}
  for at = 1, #text, 64 do
    local stream, part = block(key, 1 + (at - 1) / 64, nonce), { text:byte(at, at + 63) }
    local mixed = { stream:byte(1, #part) }
    for n, byte in ipairs(part) do mixed[n] = bxor(mixed[n], byte) end
    out[#out + 1] = char(unpack(mixed))
  end
  return concat(out)
end

-- Numbers modulo 2^130 - 5 as ten limbs of 13 bits, so that sums of products stay exact.
local LIMBS, LIMB = 10, 8192

local function limbs(bytes, count)
  local out, value, bits, at = {}, 0, 0, 1
  for n = 1, count do
    while bits < 13 and at <= #bytes do
      value, bits, at = value + bytes:byte(at) * 2 ^ bits, bits + 8, at + 1
    end
    out[n] = value % LIMB
    value, bits = math.floor(value / LIMB), math.max(0, bits - 13)
  end
  return out
end

local function carry(h)
  for _ = 1, 2 do
    local over = 0
    for n = 1, LIMBS do
      local v = h[n] + over
      over = math.floor(v / LIMB)
      h[n] = v - over * LIMB
    end
    h[1] = h[1] + 5 * over
  end
end

local function poly1305(key, text)
  local clamped = { key:byte(1, 16) }
  for _, n in ipairs({ 4, 8, 12, 16 }) do clamped[n] = clamped[n] % 16 end
  for _, n in ipairs({ 5, 9, 13 }) do clamped[n] = clamped[n] - clamped[n] % 4 end
  local r, h = limbs(char(unpack(clamped)), LIMBS), {}
  for n = 1, LIMBS do h[n] = 0 end
  for at = 1, #text, 16 do
    local m, d = limbs(text:sub(at, at + 15) .. "\1", LIMBS), {}
    for n = 1, LIMBS do h[n] = h[n] + m[n] end
    for i = 1, LIMBS do
      local sum = 0
      for j = 1, i do sum = sum + h[j] * r[i - j + 1] end
      for j = i + 1, LIMBS do sum = sum + 5 * h[j] * r[LIMBS + i - j + 1] end
      d[i] = sum
    end
    h = d
    carry(h)
  end
  carry(h)
  -- Minus 2^130 - 5, if that is not negative.
  local g, over = {}, 5
  for n = 1, LIMBS do
    local v = h[n] + over
    over = math.floor(v / LIMB)
    g[n] = v - over * LIMB
  end
  if over > 0 then h = g end
  local s, out, value, bits, limb, extra = { key:byte(17, 32) }, {}, 0, 0, 1, 0
  for n = 1, 16 do
    while bits < 8 and limb <= LIMBS do
      value, bits, limb = value + h[limb] * 2 ^ bits, bits + 13, limb + 1
    end
    local v = value % 256 + s[n] + extra
    out[n], extra = v % 256, math.floor(v / 256)
    value, bits = math.floor(value / 256), bits - 8
  end
  return char(unpack(out))
end

local function padded(text)
  return text .. ("\0"):rep(-#text % 16)
end

-- The tag over associated data and hidden text.
local function tag_of(key, nonce, data, text)
  local lengths = Struct.pack("<I4I4I4I4", #data, 0, #text, 0)
  return poly1305(block(key, 0, nonce):sub(1, 32), padded(data) .. padded(text) .. lengths)
end

-- By the sender's first four bytes: { key = 32 bytes, high = upper half of the newest number }.
local keys = {}

local function from_hex(text)
  return (text:gsub("%x%x", function(pair) return char(tonumber(pair, 16)) end))
end

-- Reads a file of padr-peer --keylog; what is wrong with it, if something is.
function seal.load(path)
  keys = {}
  if path == "" then return end
  local file, why = io.open(path)
  if not file then return why end
  local number, wrong = 0, nil
  for line in file:lines() do
    number = number + 1
    local from, to, key = line:match("^%s*padr%-key%s+(%x+)%s+(%x+)%s+(%x+)%s*$")
    if from and #from == 64 and #to == 64 and #key == 64 then
      local id = Struct.unpack("<I4", from_hex(from:sub(1, 8)))
      keys[id] = keys[id] or {}
      table.insert(keys[id], { key = from_hex(key), high = 0 })
    elseif line:match("%S") then
      wrong = wrong or ("line %d of %s is none that padr-peer --keylog writes"):format(number, path)
    end
  end
  file:close()
  return wrong
end

function seal.knows_any()
  return next(keys) ~= nil
end

-- Whether the tag of a whole sealed datagram is right, nil if no key of its sender is known; and if it is, the datagram with
-- what was hidden made readable.
function seal.open(data, envelope)
  local ring = keys[envelope.seal_id]
  if not ring then return nil end
  local head, tag = datagram.SEALED_HEADER, data:sub(-datagram.SEALED_TAG)
  local body = data:sub(head + 1, -datagram.SEALED_TAG - 1)
  local hidden = envelope.seal == "encrypt"
  local covered, text = data:sub(1, head), body
  if not hidden then covered, text = covered .. body, "" end
  for _, entry in ipairs(ring) do
    -- Late ones aside, the upper half is that of the last one or the next.
    for high = entry.high, entry.high + 1 do
      local key, nonce = inner(entry.key, envelope.seal_number, high)
      if tag_of(key, nonce, covered, text) == tag then
        entry.high = high
        return true, hidden and data:sub(1, head) .. hide(key, nonce, text) .. tag or data
      end
    end
  end
  return false
end

return seal
