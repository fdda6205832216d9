-- A worker says that it lives, and which sessions it has (docs/contracts.md, Redis). One round trip.
-- ARGV: 1 worker id, 2 incarnation, 3 address, 4 engine, 5 device, 6 slots, 7 draining, 8 load, 9 expected load, 10 volumes,
--       then session id, placement and visitor ("1": a visitor's session or a guest's own camera) of each live session
-- Returns {"beat", {sessions that were ended, or placed on another worker since: this one is to end them},
-- {sessions that are not known here, since Redis was lost: this one may write them again}}, or {"name_taken", address of another live worker}.
local worker_key, entries = keys.worker(ARGV[1]), keys.worker_sessions(ARGV[1])
local now = now_ms()

-- Another worker of this name beats: the name is its own for as long as it does. At the same address it is the process
-- before this one, dead, for a port has one owner: this one takes over at once.
local stored = redis.call('HMGET', worker_key, 'incarnation', 'address')
local before = stored[1]
if before and before ~= ARGV[2] and stored[2] and stored[2] ~= ARGV[3] then return {'name_taken', stored[2]} end

-- Sessions of the process before this one died with it; reservations made since are for this one.
if before and before ~= ARGV[2] then
  redis.call('DEL', entries)
end

local visitors = 0
local moved = {}
local unknown = {}
local listed = {}
for i = 11, #ARGV, 3 do
  local id, placement, is_visitor = ARGV[i], ARGV[i + 1], ARGV[i + 2] == '1'
  local key = keys.session(id)
  local there = redis.call('HMGET', key, 'worker', 'placement')
  -- A hash that is merely not there means that Redis was lost: the session goes on.
  local ended = redis.call('EXISTS', keys.session_ended(id)) == 1
  if ended or there[1] and there[1] ~= ARGV[1] and tonumber(there[2] or 0) > tonumber(placement) then
    redis.call('ZREM', entries, id)
    moved[#moved + 1] = id
  else
    listed[id] = true
    if not there[1] then unknown[#unknown + 1] = id end
    redis.call('ZADD', entries, now + kSessionHeldMs, id)
    if is_visitor then
      visitors = visitors + 1
      redis.call('ZADD', keys.visitors, now + kSessionHeldMs, id)
    end
    redis.call('EXPIRE', key, kSessionS)
  end
end

-- A session that this worker had (it was told by a heartbeat before) and that ended frees its slot at once;
-- a reservation whose viewer has not come yet stays until it expires.
local told = redis.call('HGET', worker_key, 'live')
if told and before == ARGV[2] then
  for id in string.gmatch(told, '[^,]+') do
    if not listed[id] then
      redis.call('ZREM', entries, id)
      redis.call('ZREM', keys.visitors, id)
    end
  end
end
redis.call('ZREMRANGEBYSCORE', entries, '-inf', now)
redis.call('EXPIRE', entries, kSlotsS)
if visitors > 0 then redis.call('EXPIRE', keys.visitors, kSlotsS) end

local live = {}
for id in pairs(listed) do live[#live + 1] = id end
redis.call('SADD', keys.workers, ARGV[1])
redis.call('HSET', worker_key, 'incarnation', ARGV[2], 'address', ARGV[3], 'engine', ARGV[4],
  'device', ARGV[5], 'slots', ARGV[6], 'draining', ARGV[7], 'load', ARGV[8], 'expected', ARGV[9],
  'volumes', ARGV[10], 'epoch', kProtocolEpoch, 'sessions', #live, 'visitors', visitors, 'used', redis.call('ZCARD', entries), 'live', table.concat(live, ','))
redis.call('PEXPIRE', worker_key, kHeartbeatMs)
return {'beat', moved, unknown}
