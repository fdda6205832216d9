-- Returns the last reports of the fleets' workers and the demand, and stores which workers are to drain
-- (docs/contracts.md). Works in pages, so that with thousands of workers, a placement waits for one page only.
--
-- ARGV: cursor ("0" to start), number of fleets, their names, then worker and owner of each draining RenderWorker
-- Returns {next cursor ("0" at the end), now ms, {recently refused sessions per fleet}, {last used ms per fleet},
--   {{owner, ms since its sample, busy, memory, sessions, used, slots, error, draining, idle since ms}, ...}}. Workers
--   that start or stop meanwhile may be missing, and any worker may occur twice.
local kPage = 256

local now = now_ms()

-- The drain request is only for the pod of this owner, because a later pod may have the same name.
local cursor, count = ARGV[1], tonumber(ARGV[2])
for i = count + 3, #ARGV, 2 do
  redis.call('SET', keys.worker_drain(ARGV[i]), ARGV[i + 1], 'PX', kDrainMs)
end

-- Returns how many sessions found no slot recently. They count towards their fleet, or the first one if api names none.
local function refused_of(key)
  redis.call('ZREMRANGEBYSCORE', key, '-inf', now - kUnplacedMs)
  return redis.call('ZCARD', key)
end
local refused = {}
for i = 1, count do refused[i] = refused_of(keys.refused(ARGV[i + 2])) end
if count > 0 then refused[1] = refused[1] + refused_of(keys.refused('')) end

local workers = {}
local taken = {}
local page = redis.call('SSCAN', keys.workers, cursor, 'COUNT', kPage)
for _, id in ipairs(page[2]) do
  local w = redis.call('HMGET', keys.worker(id), 'owner', 'sampled', 'load', 'memory', 'live', 'used',
                       'slots', 'error', 'draining', 'idle_since')
  if w[1] then
    local sessions = 0
    for _ in string.gmatch(w[5] or '', '[^,]+') do sessions = sessions + 1 end
    workers[#workers + 1] = {w[1], tostring(now - (tonumber(w[2]) or 0)), w[3] or '0', w[4] or '0', tostring(sessions), w[6] or '0',
                             w[7] or '0', w[8] or '0', w[9] or '0', w[10] or tostring(now)}
    local fleet = string.match(w[1], '^[^/]+')
    if fleet then taken[fleet] = (taken[fleet] or 0) + (tonumber(w[6]) or 0) end
  end
end

-- The time of last use is stored in Redis, so that the operator's next leader knows it too.
local last = {}
for i = 1, count do
  local fleet = ARGV[i + 2]
  local key = keys.fleet_last_used(fleet)
  if refused[i] > 0 or (taken[fleet] or 0) > 0 then
    redis.call('SET', key, now)
  else
    redis.call('SETNX', key, now)
  end
  last[i] = redis.call('GET', key)
end
for i = 1, count do refused[i] = tostring(refused[i]) end
return {page[1], tostring(now), refused, last, workers}
