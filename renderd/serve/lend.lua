-- A worker says what it does for others' pictures, and asks who could help with its own (docs/contracts.md, Redis).
-- KEYS: 1 set of workers, 2 hash of this worker
-- ARGV: 1 worker id, 2 incarnation, 3 what its own sessions ask for, 4 what it does for others; empty: nothing,
--       5 its fleet; empty: none, 6 how many to look at at random, then the ids of its helpers
-- Returns of each that lives, in one list: id, address, what its own sessions ask for, what it does for others,
-- ms since its heartbeat, whether it drains, its volumes.
local kBeatMs = 3000  -- as heartbeat.lua
local kFields = {'address', 'load', 'asked', 'lent', 'draining', 'volumes', 'owner', 'epoch'}

if redis.call('HGET', KEYS[2], 'incarnation') == ARGV[2] then
  if ARGV[4] == '' then
    redis.call('HDEL', KEYS[2], 'asked', 'lent')
  else
    redis.call('HSET', KEYS[2], 'asked', ARGV[3], 'lent', ARGV[4])
  end
end

local found, seen = {}, {[ARGV[1]] = true}
local function look(id)
  if seen[id] then return end
  seen[id] = true
  local key = 'diaphane:worker:' .. id
  local w = redis.call('HMGET', key, unpack(kFields))
  if not w[1] or w[8] ~= '1' then return end
  local fleet = string.match(w[7] or '', '^([^/]*)/') or ''
  if fleet ~= ARGV[5] then return end
  local lives = redis.call('PTTL', key)
  -- Of one that helps nobody all that it does is its own.
  local asked, lent = w[2], '0'
  if w[4] then asked, lent = w[3], w[4] end
  for _, word in ipairs({id, w[1], asked or '1', lent, tostring(math.max(0, kBeatMs - lives)), w[5] or '1', w[6] or ''}) do
    found[#found + 1] = word
  end
end

for i = 7, #ARGV do look(ARGV[i]) end
if tonumber(ARGV[6]) > 0 then
  for _, id in ipairs(redis.call('SRANDMEMBER', KEYS[1], tonumber(ARGV[6]))) do look(id) end
end
return found
