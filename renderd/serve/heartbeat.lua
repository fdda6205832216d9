-- A worker says that it lives, and which sessions it has (docs/contracts.md, Redis). One round trip.
-- KEYS: 1 set of workers, 2 hash of this worker, 3 sorted set of its sessions
-- ARGV: 1 worker id, 2 incarnation, 3 address, 4 engine, 5 device, 6 slots, 7 draining, 8 load, 9 expected load, 10 volumes,
--       11 prefix of a session's key, 12 those of the live sessions that are visitors' and guests', with commas,
--       then session id and placement of each live session
-- Returns the ids of sessions that were ended, or placed on another worker since: this one is to end them; then an
-- empty text; then the ids of sessions that are not known here (Redis was lost): this one may write them again.
local kBeatMs = 3000
local kLiveMs = 10000
local clock = redis.call('TIME')
local now = clock[1] * 1000 + math.floor(clock[2] / 1000)

-- Another worker of this name beats: the name is its own for as long as it does. At the same address it is the process
-- before this one, dead, for a port has one owner: this one takes over at once.
local stored = redis.call('HMGET', KEYS[2], 'incarnation', 'address')
local before = stored[1]
if before and before ~= ARGV[2] and stored[2] and stored[2] ~= ARGV[3] then return {'name_taken', stored[2]} end

-- Sessions of the process before this one died with it; reservations made since are for this one.
if before and before ~= ARGV[2] then
  redis.call('DEL', KEYS[3])
end

local kVisitors = 'diaphane:visitors'
local is_visitor, visitors = {}, 0
for id in string.gmatch(ARGV[12], '[^,]+') do is_visitor[id] = true end

local moved = {}
local unknown = {}
local listed = {}
for i = 13, #ARGV, 2 do
  local id, placement = ARGV[i], ARGV[i + 1]
  local key = ARGV[11] .. id
  local there = redis.call('HMGET', key, 'worker', 'placement')
  -- A hash that is merely not there means that Redis was lost: the session goes on.
  local ended = redis.call('EXISTS', key .. ':ended') == 1
  if ended or there[1] and there[1] ~= ARGV[1] and tonumber(there[2] or 0) > tonumber(placement) then
    redis.call('ZREM', KEYS[3], id)
    moved[#moved + 1] = id
  else
    listed[id] = true
    if not there[1] then unknown[#unknown + 1] = id end
    redis.call('ZADD', KEYS[3], now + kLiveMs, id)
    if is_visitor[id] then
      visitors = visitors + 1
      redis.call('ZADD', kVisitors, now + kLiveMs, id)
    end
    redis.call('EXPIRE', key, 86400)
  end
end

-- A session that this worker had (it was told by a heartbeat before) and that ended frees its slot at once;
-- a reservation whose viewer has not come yet stays until it expires.
local told = redis.call('HGET', KEYS[2], 'live')
if told and before == ARGV[2] then
  for id in string.gmatch(told, '[^,]+') do
    if not listed[id] then
      redis.call('ZREM', KEYS[3], id)
      redis.call('ZREM', kVisitors, id)
    end
  end
end
redis.call('ZREMRANGEBYSCORE', KEYS[3], '-inf', now)
redis.call('PEXPIRE', KEYS[3], 60000)
if visitors > 0 then redis.call('PEXPIRE', kVisitors, 60000) end

local live = {}
for id in pairs(listed) do live[#live + 1] = id end
redis.call('SADD', KEYS[1], ARGV[1])
redis.call('HSET', KEYS[2], 'incarnation', ARGV[2], 'address', ARGV[3], 'engine', ARGV[4],
  'device', ARGV[5], 'slots', ARGV[6], 'draining', ARGV[7], 'load', ARGV[8], 'expected', ARGV[9],
  'volumes', ARGV[10], 'epoch', '1', 'sessions', #live, 'visitors', visitors, 'used', redis.call('ZCARD', KEYS[3]), 'live', table.concat(live, ','))
redis.call('PEXPIRE', KEYS[2], kBeatMs)
moved[#moved + 1] = ''
for _, id in ipairs(unknown) do moved[#moved + 1] = id end
return moved
