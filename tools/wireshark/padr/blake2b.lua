-- BLAKE2b with a key of 32 bytes (RFC 7693). Words of 64 bits are two numbers, the lower half first.
local bxor, lshift, rshift, bor = bit.bxor, bit.lshift, bit.rshift, bit.bor
local floor, concat, unpack = math.floor, table.concat, table.unpack or unpack
local HALF, BLOCK = 4294967296, 128

local IV = {
  0xF3BCC908, 0x6A09E667, 0x84CAA73B, 0xBB67AE85, 0xFE94F82B, 0x3C6EF372, 0x5F1D36F1, 0xA54FF53A,
  0xADE682D1, 0x510E527F, 0x2B3E6C1F, 0x9B05688C, 0xFB41BD6B, 0x1F83D9AB, 0x137E2179, 0x5BE0CD19,
}

local SIGMA = {
  { 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15 },
  { 14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3 },
  { 11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4 },
  { 7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8 },
  { 9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13 },
  { 2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9 },
  { 12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11 },
  { 13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10 },
  { 6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5 },
  { 10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0 },
}

-- Words of v that a mixing step takes: columns, then diagonals.
local STEPS = {
  { 0, 4, 8, 12 }, { 1, 5, 9, 13 }, { 2, 6, 10, 14 }, { 3, 7, 11, 15 },
  { 0, 5, 10, 15 }, { 1, 6, 11, 12 }, { 2, 7, 8, 13 }, { 3, 4, 9, 14 },
}

-- The word at `to` plus that at `from` and one more.
local function add(v, to, from, low, high)
  low = v[to] + v[from] + low
  v[to + 1] = (v[to + 1] + v[from + 1] + high + floor(low / HALF)) % HALF
  v[to] = low % HALF
end

-- The word at `to` mixed with that at `from` and turned to the right by less than 32 bits.
local function turn(v, to, from, by)
  local low, high = bxor(v[to], v[from]), bxor(v[to + 1], v[from + 1])
  v[to] = bor(rshift(low, by), lshift(high, 32 - by)) % HALF
  v[to + 1] = bor(rshift(high, by), lshift(low, 32 - by)) % HALF
end

local function turn_half(v, to, from)
  v[to], v[to + 1] = bxor(v[to + 1], v[from + 1]) % HALF, bxor(v[to], v[from]) % HALF
end

-- By 63 bits, which is one to the left.
local function turn_back(v, to, from)
  local low, high = bxor(v[to], v[from]), bxor(v[to + 1], v[from + 1])
  v[to] = bor(lshift(low, 1), rshift(high, 31)) % HALF
  v[to + 1] = bor(lshift(high, 1), rshift(low, 31)) % HALF
end

local function compress(h, block, so_far, last)
  local m, v = { Struct.unpack("<" .. ("I4"):rep(32), block) }, {}
  for n = 1, 16 do v[n], v[16 + n] = h[n], IV[n] end
  v[25] = bxor(v[25], so_far) % HALF
  if last then v[29], v[30] = bxor(v[29], -1) % HALF, bxor(v[30], -1) % HALF end
  for round = 0, 11 do
    local order = SIGMA[round % 10 + 1]
    for n, step in ipairs(STEPS) do
      local a, b, c, d = 2 * step[1] + 1, 2 * step[2] + 1, 2 * step[3] + 1, 2 * step[4] + 1
      local x, y = 2 * order[2 * n - 1] + 1, 2 * order[2 * n] + 1
      add(v, a, b, m[x], m[x + 1])
      turn_half(v, d, a)
      add(v, c, d, 0, 0)
      turn(v, b, c, 24)
      add(v, a, b, m[y], m[y + 1])
      turn(v, d, a, 16)
      add(v, c, d, 0, 0)
      turn_back(v, b, c)
    end
  end
  for n = 1, 16 do h[n] = bxor(bxor(h[n], v[n]), v[16 + n]) % HALF end
end

-- The first `size` bytes, a multiple of 4, of the hash of `text`.
local function blake2b(key, text, size)
  local h = { unpack(IV) }
  h[1] = bxor(h[1], 0x01010000 + 256 * #key + size) % HALF
  text = key .. ("\0"):rep(BLOCK - #key) .. text
  local blocks = math.ceil(#text / BLOCK)
  for n = 1, blocks do
    local block = text:sub((n - 1) * BLOCK + 1, n * BLOCK)
    compress(h, block .. ("\0"):rep(BLOCK - #block), math.min(n * BLOCK, #text), n == blocks)
  end
  local out = {}
  for n = 1, size / 4 do out[n] = Struct.pack("<I4", h[n]) end
  return concat(out)
end

return blake2b
