-- Stores the capacity that a worker lends, and returns the peers that could help with its own pictures
-- (docs/contracts.md, Redis).
-- ARGV: 1 worker id, 2 incarnation, 3 demand of its own sessions, 4 lent capacity (empty: none), 5 its fleet (empty:
--       none), 6 number of random peers to consider, then the ids of its helpers
-- Returns {{id, address, demand, lent capacity, ms since its heartbeat, draining, volumes, node}, ...} of live workers.
local kFields = {'address', 'load', 'asked', 'lent', 'draining', 'volumes', 'owner', 'epoch', 'node'}

if redis.call('HGET', keys.worker(ARGV[1]), 'incarnation') == ARGV[2] then
  if ARGV[4] == '' then
    redis.call('HDEL', keys.worker(ARGV[1]), 'asked', 'lent')
  else
    redis.call('HSET', keys.worker(ARGV[1]), 'asked', ARGV[3], 'lent', ARGV[4])
  end
end

local found, visited = {}, {[ARGV[1]] = true}
local function consider(id)
  if visited[id] then return end
  visited[id] = true
  local key = keys.worker(id)
  local w = redis.call('HMGET', key, unpack(kFields))
  if not w[1] or w[8] ~= tostring(kProtocolEpoch) then return end
  local fleet = string.match(w[7] or '', '^([^/]*)/') or ''
  if fleet ~= ARGV[5] then return end
  local lives = redis.call('PTTL', key)
  -- Without lent capacity, the whole load is the worker's own demand.
  local asked, lent = w[2], '0'
  if w[4] then asked, lent = w[3], w[4] end
  found[#found + 1] = {id, w[1], asked or '1', lent, tostring(math.max(0, kHeartbeatMs - lives)), w[5] or '1', w[6] or '', w[9] or ''}
end

for i = 7, #ARGV do consider(ARGV[i]) end
if tonumber(ARGV[6]) > 0 then
  for _, id in ipairs(redis.call('SRANDMEMBER', keys.workers, tonumber(ARGV[6]))) do consider(id) end
end
return found
