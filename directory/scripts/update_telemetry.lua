-- Runs after each heartbeat of a worker that the operator created: stores its telemetry and returns the operator's orders
-- (docs/contracts.md, Redis).
-- ARGV: 1 worker id, 2 incarnation, 3 owner, 4 used memory for volumes (0 to 1), 5 sum of the errors of all its pictures
-- Returns -1 if the worker continues. Otherwise, it drains, and this many sessions currently fit on other workers.
local worker_key = keys.worker(ARGV[1])
local before = redis.call('HMGET', worker_key, 'incarnation', 'used', 'idle_since', 'live')
if before[1] ~= ARGV[2] then return -1 end
local now = now_ms()

redis.call('HSET', worker_key, 'owner', ARGV[3], 'memory', ARGV[4], 'error', ARGV[5], 'sampled', now)
if before[2] ~= '0' then
  redis.call('HDEL', worker_key, 'idle_since')
elseif not before[3] then
  redis.call('HSET', worker_key, 'idle_since', now)
end

-- A drain request for the previous pod does not apply to this one.
if redis.call('GET', keys.worker_drain(ARGV[1])) ~= ARGV[3] then return -1 end
redis.call('HSET', worker_key, 'draining', '1')
local room = 0
if before[4] and before[4] ~= '' then
  -- A draining worker moves only a few sessions per second, so the free slots of this many workers are enough.
  for _, id in ipairs(redis.call('SRANDMEMBER', keys.workers, 64)) do
    if id ~= ARGV[1] then
      local w = redis.call('HMGET', keys.worker(id), 'slots', 'draining')
      if w[1] and w[2] ~= '1' then
        local used = redis.call('ZCOUNT', keys.worker_sessions(id), now, '+inf')
        room = room + math.max(0, tonumber(w[1]) - used)
      end
    end
  end
end
return room
