-- Wireshark and tshark learn to read PADR's datagrams: on UDP, on any port. README.md beside this file tells how to install it;
-- proto/WIRE.md says what the bytes mean, padr/fields.lua lists the filter fields.
--
-- This file has what Wireshark calls. padr/datagram.lua decodes, padr/seal.lua decrypts, padr/history.lua knows what was before, padr/show.lua fills the
-- tree, padr/sentence.lua the info column.
do -- installed, and named on the command line besides: once is enough
  local ok, there = pcall(Dissector.get, "padr")
  if ok and there then return end
end

package.path = (debug.getinfo(1, "S").source:match("^@(.*[/\\])") or "./") .. "?.lua;" .. package.path
local datagram = require("padr.datagram")
local fields = require("padr.fields")
local history = require("padr.history")
local seal = require("padr.seal")
local Show = require("padr.show")
local sentence = require("padr.sentence")

local padr = Proto("padr", "Physics-Aware Dead Reckoning")
local f, labels = fields.all()
padr.fields = f
local experts = {
  tag = ProtoExpert.new("padr.expert.tag", "The CRC does not fit", expert.group.CHECKSUM, expert.severity.ERROR),
  seal = ProtoExpert.new("padr.expert.seal", "The seal fits no key in the key log", expert.group.SECURITY, expert.severity.WARN),
  malformed = ProtoExpert.new("padr.expert.malformed", "Everybody drops this", expert.group.MALFORMED, expert.severity.ERROR),
  cut = ProtoExpert.new("padr.expert.cut", "Cut off by the capture", expert.group.UNDECODED, expert.severity.NOTE),
  resend = ProtoExpert.new("padr.expert.resend", "Update sent again", expert.group.SEQUENCE, expert.severity.NOTE),
  superseded = ProtoExpert.new("padr.expert.superseded", "Claim that loses", expert.group.SEQUENCE, expert.severity.WARN),
  stale = ProtoExpert.new("padr.expert.stale_mark", "Stale mark", expert.group.SEQUENCE, expert.severity.NOTE),
  duplicate = ProtoExpert.new("padr.expert.duplicate", "Duplicate datagram", expert.group.SEQUENCE, expert.severity.NOTE),
  lost = ProtoExpert.new("padr.expert.lost", "Numbers skipped so far; some may come later", expert.group.SEQUENCE, expert.severity.NOTE),
  differs = ProtoExpert.new("padr.expert.check_differs", "Confirmed worlds differ", expert.group.SEQUENCE, expert.severity.ERROR),
  admission = ProtoExpert.new("padr.expert.admission", "A peer comes in", expert.group.SEQUENCE, expert.severity.CHAT),
  removal = ProtoExpert.new("padr.expert.removal", "A peer is declared gone", expert.group.SEQUENCE, expert.severity.CHAT),
  refuse = ProtoExpert.new("padr.expert.refuse", "A newcomer is refused", expert.group.RESPONSE_CODE, expert.severity.WARN),
}
padr.experts = experts

local NEVER, INSTALLED, ALWAYS = 0, 1, 2
padr.prefs.protobuf = Pref.enum("Show the payload as protobuf too", INSTALLED,
  "By Wireshark's own dissector, which knows the fields' names if it has wire.proto (README.md of the plugin)",
  { { 1, "Never", NEVER }, { 2, "If wire.proto is installed", INSTALLED }, { 3, "Always", ALWAYS } }, false)

padr.prefs.keylog = Pref.string("Key log", "", "A file that padr-peer --keylog has written, or several put together: checks and decrypts what is sealed")

local opened = {} -- by frame: whether the seal is right, and the datagram made readable
local function read_keylog()
  opened = {}
  local wrong = seal.load(padr.prefs.keylog)
  if wrong then report_failure("PADR's key log: " .. wrong) end
end
padr.prefs_changed = read_keylog

local protobuf = Dissector.get("protobuf")
local MESSAGES = { [0] = "padr.wire.State", "padr.wire.Session", "padr.wire.Membership" }

function padr.init()
  history.reset()
  read_keylog() -- a peer may have written more of it
end

local function show_handshake(show, tree, envelope)
  local tvb = show.tvb
  show:add(tree, "padr.handshake", envelope.handshake, tvb(3, 1))
  if not envelope.whole then return end
  show:raw(tree, "padr.handshake.key", tvb(4, 32))
  show:raw(tree, "padr.handshake.number", tvb(36, 8))
  if envelope.handshake == "rekey" then
    show:add(tree, "padr.seal.id", tvb(44, 4):le_uint(), tvb(44, 4))
    show:add(tree, "padr.handshake.generation", tvb(48, 4):le_uint(), tvb(48, 4))
    show:raw(tree, "padr.handshake.has", tvb(52, 8))
  else
    show:raw(tree, "padr.handshake.cookie", tvb(44, 16))
  end
  show:raw(tree, "padr.seal.tag", tvb(60, datagram.SEALED_TAG))
end

-- Once for each frame: it takes a millisecond, and what numbers have been here is to be asked in order.
local function open_seal(number, data, envelope)
  if not envelope.seal or not envelope.whole then return nil, data end
  local known = opened[number]
  if not known then
    local good, readable = seal.open(data, envelope)
    known = { good = good, readable = readable }
    if good ~= nil then opened[number] = known end
  end
  return known.good, known.readable or data
end

local function show_seal(show, tree, envelope, size)
  local tvb = show.tvb
  show:add(tree, "padr.seal", envelope.seal, tvb(2, 1))
  if not envelope.seal_id then return end
  show:add(tree, "padr.seal.id", envelope.seal_id, tvb(6, 4))
  show:add(tree, "padr.seal.number", envelope.seal_number, tvb(10, 4))
  if not envelope.whole then return end
  local range = tvb(size - datagram.SEALED_TAG, datagram.SEALED_TAG)
  show:raw(tree, "padr.seal.tag", range)
  if envelope.seal_good == nil then return end
  local item = show:add(tree, "padr.seal.good", envelope.seal_good, range)
  if not envelope.seal_good then item:add_proto_expert_info(experts.seal) end
end

local function show_envelope(show, tree, envelope, size)
  local tvb = show.tvb
  show:add(tree, "padr.version", envelope.version, tvb(2, 1))
  if envelope.handshake then return show_handshake(show, tree, envelope) end
  show:add(tree, "padr.kind", envelope.kind, tvb(2, 1))
  show:add(tree, "padr.peer", envelope.peer, tvb(3, 1))
  show:add(tree, "padr.session", envelope.session, tvb(4, 2))
  if envelope.seal then show_seal(show, tree, envelope, size) end
  if not envelope.tag then return end
  local range = tvb(size - datagram.TAG, datagram.TAG)
  show:add(tree, "padr.tag", envelope.tag, range)
  show:add(tree, "padr.tag_good", envelope.tag_good, range)
end

local STATE_FIELDS = {
  { "seq", "seq" }, { "tick", "mark_tick" }, { "mark_count", "mark_count" }, { "have", "have" },
  { "have_beyond", "have_beyond" }, { "seen_seq", "seen_seq" }, { "seen_age", "seen_age" }, { "transit", "transit" },
  { "loss", "loss" }, { "incarnation", "incarnation" }, { "to_incarnation", "to_incarnation" },
}

-- What was found out about the datagram as a whole. The texts of experts are always the same, so that Wireshark counts them
-- together; particulars are in the fields.
local FINDINGS = {
  { "stale_mark", experts.stale }, { "duplicate", experts.duplicate }, { "lost", experts.lost },
  { "check_differs", experts.differs },
}

local function show_findings(show, tree, found)
  for _, finding in ipairs(FINDINGS) do
    local name, expert = finding[1], finding[2]
    if found[name] then show:add(tree, "padr." .. name, found[name]):add_proto_expert_info(expert) end
  end
end

local function show_state(show, tree, said, found)
  local state, bodies = said.state, 0
  history.each_body(said.updates, function() bodies = bodies + 1 end)
  for _, names in ipairs(STATE_FIELDS) do show:value(tree, "padr." .. names[1], state[names[2]]) end
  if state.check_hash.v ~= 0 then
    show:value(tree, "padr.check_age", state.check_age)
    show:add(tree, "padr.check_tick", state.mark_tick.v - state.check_age.v)
    show:value(tree, "padr.check_hash", state.check_hash)
  end
  show:add(tree, "padr.mark", #said.updates == 0)
  show:add(tree, "padr.updates", #said.updates)
  show:add(tree, "padr.bodies", bodies)
  for n, update in ipairs(said.updates) do show:update(tree, update, found.resend[n]) end
  show_findings(show, tree, found)
end

local function show_message(show, tree, said, found)
  show:add(tree, "padr.message", said.name)
  show:message(tree, "padr." .. said.name, said.spec, said.message)
  if said.name == "refuse" then
    tree:add_proto_expert_info(experts.refuse)
  elseif said.name == "fetched" then
    show:value(tree, "padr.fetched.mark_tick", said.message.state.mark_tick)
    show:value(tree, "padr.fetched.mark_count", said.message.state.mark_count)
    for _, update in ipairs(said.updates) do show:update(tree, update) end
  elseif found.transfer then
    local whole = ByteArray.new(found.transfer, true):tvb("Transfer")
    Show.new(f, labels, experts, whole, { superseded = {} }):transfer(tree, found.transfer)
  end
end

-- Whether Wireshark has wire.proto where it looks without being told.
local function is_proto_installed()
  for _, path in ipairs({ Dir.personal_config_path("protobuf/wire.proto"), Dir.global_config_path("protobuf/wire.proto") }) do
    local file = io.open(path)
    if file then
      file:close()
      return true
    end
  end
  return false
end

local proto_is_installed = is_proto_installed()

-- Wireshark's own reading of the payload. What goes wrong in it must not spoil ours.
local function show_protobuf(tvb, pinfo, root, envelope)
  local size, wanted = tvb:len() - envelope.header_size - envelope.tag_size, padr.prefs.protobuf
  if not protobuf or size < 1 or wanted == NEVER or wanted == INSTALLED and not proto_is_installed then return end
  pinfo.private["pb_msg_type"] = "message," .. MESSAGES[envelope.kind]
  pcall(Dissector.call, protobuf, tvb(envelope.header_size, size):tvb(), pinfo, root)
end

local function show_drop(show, tree, reason, detail)
  local item = show:add(tree, "padr.drop", reason)
  item:add_proto_expert_info(reason == "tag" and experts.tag or experts.malformed)
  if detail then item:append_text(" (" .. detail .. ")") end
end

-- What is in a datagram of kind 3 is one more, of whoever has sealed it.
local dissect
local function dissect_carried(tvb, pinfo, root, tree, show, readable, outer)
  local to, at = datagram.carried(readable)
  if not to then return show_drop(show, tree, "malformed") end
  show:add(tree, "padr.carried.to", to, tvb(at - 5, 4))
  local size = #readable - datagram.SEALED_TAG - at + 1
  local inner = readable:sub(at, at + size - 1)
  local envelope = datagram.envelope(inner, size)
  if envelope.seal and envelope.kind ~= datagram.CARRIED or envelope.handshake then
    dissect(tvb(at - 1, size):tvb(), pinfo, root, inner, envelope, to, outer)
    pinfo.cols.info:prepend("carried, ")
  end
end

-- `carried`: the short id of whom a carried one is for; `hop`: of who sent what it is in.
function dissect(tvb, pinfo, root, data, envelope, carried, hop)
  local size = tvb:reported_len()
  local reason, said, detail = datagram.envelope_drop(envelope, size)
  local readable
  envelope.seal_good, readable = open_seal(carried and -pinfo.number or pinfo.number, data, envelope)
  local decrypted = envelope.seal == "encrypt" and envelope.seal_good
  local hidden = envelope.handshake or envelope.seal_good == false or envelope.seal == "encrypt" and not decrypted
  local carries = envelope.seal and envelope.kind == datagram.CARRIED
  if not reason and envelope.whole and not hidden and not carries then
    said, reason, detail = datagram.decode(readable, envelope)
  end
  local from, to = history.place(pinfo.src, pinfo.src_port), history.place(pinfo.dst, pinfo.dst_port)
  if carried then from, to = "id " .. tostring(envelope.seal_id), "id " .. carried end
  if said and not pinfo.visited and not pinfo.in_error_pkt then
    history.note(pinfo.number, from, to, envelope, said, hop)
  end
  local found = history.of(pinfo.number)
  found.to = history.receiver(pinfo.number, to)

  local tree = root:add(padr, tvb())
  local show = Show.new(f, labels, experts, tvb, found)
  show_envelope(show, tree, envelope, size)
  if found.to then show:add(tree, "padr.to", found.to) end
  if decrypted then
    tvb = ByteArray.new(readable, true):tvb("Decrypted")
    show = Show.new(f, labels, experts, tvb, found)
  end
  if reason then
    show_drop(show, tree, reason, detail)
  elseif hidden then
    -- Nothing to read.
  elseif not envelope.whole then
    tree:add_proto_expert_info(experts.cut)
  elseif carries then
    pinfo.cols.protocol:set("PADR")
    tree:append_text(", carries for another peer")
    dissect_carried(tvb, pinfo, root, tree, show, readable, envelope.seal_id)
    return #data
  elseif said.name == "state" then
    show_state(show, tree, said, found)
  else
    show_message(show, tree, said, found)
  end
  if said then show_protobuf(tvb, pinfo, root, envelope) end
  pinfo.cols.protocol:set("PADR")
  local info = sentence.of(envelope, said, found, reason)
  pinfo.cols.info:set(info)
  tree:append_text(", " .. info)
  return #data
end

-- Whether what begins with the magic is ours: the tag fits or, for what was damaged or cut off, the header is as ours are. Of
-- bytes at random that begin so, one in six hundred has such a header.
local function is_ours(envelope)
  if envelope.tag_good or envelope.handshake then return true end
  local sender_is_one = envelope.peer < 64 or envelope.peer == datagram.NOBODY
  local kind_is_one = datagram.KINDS[envelope.kind] ~= nil and (envelope.seal or envelope.kind ~= datagram.CARRIED)
  return envelope.version == datagram.VERSION and kind_is_one and sender_is_one
end

local function dissect_ours(tvb, pinfo, root)
  if tvb:captured_len() < datagram.HEADER or tvb(0, 2):uint() ~= datagram.MAGIC then return false end
  local data = tvb:raw()
  local envelope = datagram.envelope(data, tvb:reported_len())
  if not is_ours(envelope) then return false end
  dissect(tvb, pinfo, root, data, envelope)
  return true
end

-- Wireshark asks who has a port before it asks by what the bytes look like. 7000 to 7009, which all examples use, AFS has: what is
-- ours is taken from it, and nothing else.
local ports = DissectorTable.get("udp.port")
local afs = ports:get_dissector(7001)
local function is_of_afs(port) return afs and port >= 7000 and port <= 7009 end

-- By its port, nobody has looked at the bytes yet. On others than those it is Decode As that says so.
function padr.dissector(tvb, pinfo, root)
  if is_of_afs(pinfo.match_uint) then
    return dissect_ours(tvb, pinfo, root) and tvb:len() or afs:call(tvb, pinfo, root)
  end
  if tvb:captured_len() < datagram.HEADER then return 0 end
  local data = tvb:raw()
  return dissect(tvb, pinfo, root, data, datagram.envelope(data, tvb:reported_len()))
end

padr:register_heuristic("udp", dissect_ours)
ports:add_for_decode_as(padr)
for port = 7000, 7009 do
  if is_of_afs(port) then ports:add(port, padr) end
end
