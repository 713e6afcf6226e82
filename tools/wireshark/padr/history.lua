-- What datagrams say about one another: who the receiver is, what was sent again, which claim loses, what the wire left out.
-- Everything is found when a frame is seen for the first time, in the order of the capture, and kept by frame number: what
-- Wireshark shows of a frame later, or in a second pass, is the same.
local history = {}

local noted -- by frame number: what was found out about it
local receivers -- by frame number and place: the slot, or false
local addresses -- Wireshark's objects
local by_text -- by what an address was shown as: its index in them
local numbers -- by place: the slot of whose datagrams last came from there
local links -- directed, by places, session and incarnations
local claims -- by session and body: epoch -> array of {peer, claimed, tick, frame}
local checks -- by session and tick: the first hash told
local transfers -- by link and nonce: the pieces of one transfer

-- To be called when a capture is opened, or dissected anew.
function history.reset()
  noted, receivers, addresses, by_text, numbers, links, claims, checks, transfers = {}, {}, {}, {}, {}, {}, {}, {}, {}
end
history.reset()

local function entry(table, key, make)
  local value = table[key]
  if not value then
    value = make()
    table[key] = value
  end
  return value
end

local function table_of_none()
  return {}
end

-- An address is shown as a name as soon as one is found, and two may have the same: what counts is that they are equal.
local function index_of(address)
  local text = tostring(address)
  local index = by_text[text]
  if index and addresses[index] == address then return index end
  index = 1
  while addresses[index] and addresses[index] ~= address do index = index + 1 end
  addresses[index], by_text[text] = address, index
  return index
end

-- A place that datagrams come from and go to, as a key of tables.
function history.place(address, port)
  return index_of(address) .. " " .. port
end

local LOT_FACTOR = UInt64(0x1E98DF25, 0x9FB21C65)

-- The lot of a claim, proto/WIRE.md section 6.
function history.lot(peer, body, epoch)
  local h = UInt64(0x84222325, 0xCBF29CE4)
  for _, v in ipairs({ peer, body, epoch }) do
    h = h:bxor(UInt64(v)) * LOT_FACTOR
    h = h:bxor(h:rshift(35))
  end
  h = h * LOT_FACTOR
  return h:bxor(h:rshift(28))
end

-- Whether of two claims of different peers on the same body in the same epoch the first one wins: the earlier one, then the
-- smaller lot, then the lower peer.
function history.wins(a, b, body, epoch)
  if a.claimed ~= b.claimed then return a.claimed < b.claimed end
  local lot_a, lot_b = history.lot(a.peer, body, epoch), history.lot(b.peer, body, epoch)
  if lot_a == lot_b then return a.peer < b.peer end
  return lot_a < lot_b
end

-- Whether a claim was told before an update of that tick and peer, in the order in which all peers fold updates.
local function is_before(claim, tick, peer)
  return claim.tick < tick or claim.tick == tick and claim.peer < peer
end

local LATER_EPOCHS = 64 -- looked at, at most: they are few, unless somebody makes them up

-- The first claim told, in the order of folding, before `claim` that beats it. `of_body` is what is filed of its body.
local function better(of_body, claim, body, epoch)
  for later = of_body.newest, math.max(epoch + 1, of_body.newest - LATER_EPOCHS), -1 do
    for _, other in ipairs(of_body.by_epoch[later] or {}) do
      if is_before(other, claim.tick, claim.peer) then return other end
    end
  end
  for _, other in ipairs(of_body.by_epoch[epoch] or {}) do
    local is_told = other.peer ~= claim.peer and is_before(other, claim.tick, claim.peer)
    if is_told and history.wins(other, claim, body, epoch) then return other end
  end
end

-- Files the claim that a body's state rests on. Gives the frame of a claim that it loses against, if there is one.
local function file_claim(session, update, body, frame)
  local of_session = entry(claims, session, table_of_none)
  local of_body = entry(of_session, body.id.v, function() return { newest = 0, by_epoch = {} } end)
  local epoch, claim = body.epoch.v, { peer = update.peer, claimed = body.claimed, tick = update.tick, frame = frame }
  local winner = better(of_body, claim, body.id.v, epoch)
  local of_epoch, known = entry(of_body.by_epoch, epoch, table_of_none), nil
  for _, other in ipairs(of_epoch) do
    if other.peer == claim.peer and other.claimed == claim.claimed then known = other end
  end
  if not known then
    of_epoch[#of_epoch + 1] = claim
  elseif claim.tick < known.tick then
    known.tick, known.frame = claim.tick, frame
  end
  of_body.newest = math.max(of_body.newest, epoch)
  return winner and winner.frame
end

-- Calls each(body, update, n) of all bodies, those of updates passed on included; n counts from 1.
function history.each_body(list, each)
  local n = 0
  for _, update in ipairs(list) do
    while update do
      for _, body in ipairs(update.bodies) do
        n = n + 1
        each(body, update, n)
      end
      update = update.inner
    end
  end
end

local function note_claims(found, session, list, frame)
  history.each_body(list, function(body, update, n)
    if body.state then found.superseded[n] = file_claim(session, update, body, frame) end
  end)
end

-- Whether the number was on the link before. What is carried is so once on each hop, which is no duplicate.
local function is_again(found, link, seq, frame, hop)
  local hops = link.seqs[seq] or {}
  local is_new = next(hops) == nil
  found.duplicate = hops[hop or 0]
  hops[hop or 0] = found.duplicate or frame
  link.seqs[seq] = hops
  return not is_new
end

local function note_link(found, link, state, list, frame, hop)
  local seq, tick = state.seq.v, state.mark_tick.v
  if is_again(found, link, seq, frame, hop) then return true end
  if link.seq and seq > link.seq + 1 then found.lost = seq - link.seq - 1 end
  if link.tick and tick <= link.tick then found.stale_mark = link.tick end
  if not link.seq or seq > link.seq then link.seq = seq end
  if not link.tick or tick > link.tick then link.tick = tick end
  for n, update in ipairs(list) do
    found.resend[n] = link.updates[update.index]
    link.updates[update.index] = link.updates[update.index] or frame
  end
end

local function note_check(found, session, state, frame)
  if state.check_hash.v == 0 then return end
  local tick, hash = state.mark_tick.v - state.check_age.v, state.check_hash.v
  local of_session = entry(checks, session, table_of_none)
  local first = entry(of_session, tick, function() return { hash = hash, frame = frame } end)
  if first.hash ~= hash then found.check_differs = first.frame end
end

local function note_state(found, envelope, from, to, said, frame, hop)
  local state = said.state
  local key = table.concat({ from, to, envelope.session, envelope.peer, state.incarnation.v, state.to_incarnation.v }, " ")
  local link = entry(links, key, function() return { seqs = {}, updates = {} } end)
  local again = note_link(found, link, state, said.updates, frame, hop)
  if not again then note_claims(found, envelope.session, said.updates, frame) end
  note_check(found, envelope.session, state, frame)
end

-- The whole transfer, in the frame with the last piece that was missing.
local function note_piece(found, envelope, from, to, piece)
  local key = table.concat({ from, to, envelope.session, piece.nonce.v }, " ")
  local transfer = entry(transfers, key, function() return { pieces = {}, have = 0, count = piece.count.v } end)
  if transfer.done or transfer.count ~= piece.count.v or transfer.pieces[piece.index.v + 1] then return end
  transfer.pieces[piece.index.v + 1] = piece.bytes.v
  transfer.have = transfer.have + 1
  if transfer.have < transfer.count then return end
  found.transfer = table.concat(transfer.pieces)
  transfer.done, transfer.pieces = true, {}
end

-- Files a datagram that is whole and well formed, once for each frame. `hop`: who sent it, if that is another one's datagram.
function history.note(frame, from, to, envelope, said, hop)
  if noted[frame] then return end
  local found = { resend = {}, superseded = {} }
  noted[frame] = found
  if envelope.peer ~= 255 then numbers[from] = envelope.peer end
  if said.name == "welcome" then numbers[to] = said.message.peer.v end
  if said.name == "state" then
    note_state(found, envelope, from, to, said, frame, hop)
  elseif said.name == "piece" then
    note_piece(found, envelope, from, to, said.message)
  end
end

-- What was found out about a frame; of one that was not noted, nothing.
function history.of(frame)
  return noted[frame] or { resend = {}, superseded = {} }
end

-- The slot of whoever had last sent from that place when the frame was seen first, if anybody had. To be asked after note().
function history.receiver(frame, place)
  local of_frame = entry(receivers, frame, table_of_none)
  if of_frame[place] == nil then of_frame[place] = numbers[place] or false end
  return of_frame[place] or nil
end

return history
