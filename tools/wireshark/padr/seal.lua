-- What sealed datagrams hide, and whether their tags are right, given what padr-peer --keylog has written: BLAKE2b and XChaCha20
-- (draft-irtf-cfrg-xchacha-03, RFC 8439) as section 14 of proto/WIRE.md uses them. No cipher of Wireshark's own is within reach of Lua.
local blake2b = require("padr.blake2b")
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

-- The key and the nonce of RFC 8439 for the 24 bytes of an XChaCha20 nonce.
local function inner(key, long)
  local w = state_of(key, words(long:sub(1, 16)))
  permute(w)
  local last = words(long:sub(17))
  return bytes_of({ w[1], w[2], w[3], w[4], w[13], w[14], w[15], w[16] }, 8), { 0, last[1], last[2] }
end

local function hide(key, nonce, text)
  local out = {}
  for at = 1, #text, 64 do
    local stream, part = block(key, (at - 1) / 64, nonce), { text:byte(at, at + 63) }
    local mixed = { stream:byte(1, #part) }
    for n, byte in ipairs(part) do mixed[n] = bxor(mixed[n], byte) end
    out[#out + 1] = char(unpack(mixed))
  end
  return concat(out)
end

-- By the sender's first four bytes: a list of { key = 32 bytes, cipher = what hides, by that key }, those that were of use last in
-- front, and in `high` the upper half of the newest number.
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
  local _, unreadable = file:read(0) -- a folder can be opened
  if unreadable then
    file:close()
    return path .. ": " .. unreadable
  end
  local number, wrong = 0, nil
  for line in file:lines() do
    number = number + 1
    local from, to, key = line:match("^%s*padr%-key%s+(%x+)%s+(%x+)%s+(%x+)%s*$")
    if from and #from == 64 and #to == 64 and #key == 64 then
      local id = Struct.unpack("<I4", from_hex(from:sub(1, 8)))
      keys[id] = keys[id] or { high = 0 }
      table.insert(keys[id], { key = from_hex(key) })
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

local function shown(entry, long, text)
  entry.cipher = entry.cipher or blake2b(entry.key, "padr cipher", 32)
  local key, nonce = inner(entry.cipher, long)
  return hide(key, nonce, text)
end

-- Whether the tag of a whole sealed datagram is right, nil if no key of its sender is known; and if it is, the datagram with
-- what was hidden made readable.
function seal.open(data, envelope)
  local ring = keys[envelope.seal_id]
  if not ring then return nil end
  local head, tag = datagram.SEALED_HEADER, data:sub(-datagram.SEALED_TAG)
  local body = data:sub(head + 1, -datagram.SEALED_TAG - 1)
  local hidden = envelope.seal == "encrypt"
  -- Late ones aside, the upper half is that of the last one or the next.
  for high = ring.high, ring.high + 1 do
    local number = Struct.pack("<I4I4", envelope.seal_number, high)
    for n, entry in ipairs(ring) do
      local text = hidden and shown(entry, tag .. number, body) or body
      if blake2b(entry.key, data:sub(1, head) .. text .. number, #tag) == tag then
        ring.high = high
        table.insert(ring, 1, table.remove(ring, n))
        return true, hidden and data:sub(1, head) .. text .. tag or data
      end
    end
  end
  return false
end

return seal
