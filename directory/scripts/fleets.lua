-- What the workers of fleets said last, whom to tell that it drains, and how much is asked for (docs/contracts.md): of thousands of workers a page, so
-- that who asks for a place waits for a page and not for all.
--
-- ARGV: cursor ("0": from the first), number of fleets, their names, then worker and owner of each RenderWorker that drains
-- Returns {next cursor ("0": that was all), now ms, {refused in the last seconds by each fleet}, {last used ms of each fleet},
--   {{owner, ms since its sample, busy, memory, sessions, used, slots, error, draining, idle since ms}, ...}}. A worker that comes or goes
--   meanwhile may be missing, and any may come twice.
local kPage = 256

local now = now_ms()

-- For the pod of this owner alone: the next of its name is another.
local cursor, count = ARGV[1], tonumber(ARGV[2])
for i = count + 3, #ARGV, 2 do
  redis.call('SET', keys.worker_drain(ARGV[i]), ARGV[i + 1], 'PX', kDrainMs)
end

-- Who found no place wants one of one fleet: where api names none, of the first.
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

-- Kept here, so that the next leader knows it too.
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
