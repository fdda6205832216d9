-- Stores that a worker is alive and which sessions it has, in one round trip (docs/contracts.md, Redis).
-- ARGV: 1 worker id, 2 incarnation, 3 address, 4 engine, 5 device, 6 slots, 7 draining, 8 load, 9 expected load,
--       10 volumes, 11 node (empty: unknown), then of each live session its id, placement and visitor ("1": a
--       visitor's session or a guest's free camera)
-- Returns {"beat", {sessions to end, because they were ended or placed on another worker}, {sessions to restore, because
-- Redis has lost them}}, or {"name_taken", address of another live worker}.
local worker_key, entries = keys.worker(ARGV[1]), keys.worker_sessions(ARGV[1])
local now = now_ms()

-- A worker with fresh heartbeats owns its name. A worker at the same address must be the previous process, which has
-- ended because a port has only one owner, so this worker takes over immediately.
local stored = redis.call('HMGET', worker_key, 'incarnation', 'address')
local before = stored[1]
if before and before ~= ARGV[2] and stored[2] and stored[2] ~= ARGV[3] then return {'name_taken', stored[2]} end

-- The sessions of the previous process ended with it. Reservations made from now on are for this one.
if before and before ~= ARGV[2] then
  redis.call('DEL', entries)
end

local visitors = 0
local moved = {}
local unknown = {}
local listed = {}
for i = 12, #ARGV, 3 do
  local id, placement, is_visitor = ARGV[i], ARGV[i + 1], ARGV[i + 2] == '1'
  local key = keys.session(id)
  local there = redis.call('HMGET', key, 'worker', 'placement')
  -- If only the session's hash is missing, Redis has lost its data, and the session continues.
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

-- Frees the slots of sessions that have ended since the last heartbeat. A reservation whose viewer has not arrived yet
-- stays until it expires.
local previous = redis.call('HGET', worker_key, 'live')
if previous and before == ARGV[2] then
  for id in string.gmatch(previous, '[^,]+') do
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
  'volumes', ARGV[10], 'node', ARGV[11], 'epoch', kProtocolEpoch, 'sessions', #live, 'visitors', visitors, 'used', redis.call('ZCARD', entries), 'live', table.concat(live, ','))
redis.call('PEXPIRE', worker_key, kHeartbeatMs)
return {'beat', moved, unknown}
