-- Forget sessions and give their slots back at once; the workers hear of it with their next heartbeat.
--
-- ARGV: "session", "data_set" or "user", id; or "browser", its id, the id of its user. Returns how many sessions were ended.

local function finish(session)
  local session_key = 'diaphane:session:' .. session
  local s = redis.call('HMGET', session_key, 'user', 'data_set', 'worker')
  if not s[1] then return 0 end
  redis.call('ZREM', 'diaphane:user:' .. s[1] .. ':sessions', session)
  redis.call('ZREM', 'diaphane:data_set:' .. s[2] .. ':sessions', session)
  if s[3] then redis.call('ZREM', 'diaphane:worker:' .. s[3] .. ':sessions', session) end
  for _, hash in ipairs(redis.call('SMEMBERS', session_key .. ':links')) do
    redis.call('DEL', 'diaphane:link:' .. hash)
  end
  redis.call('ZREM', 'diaphane:visitors', session)
  redis.call('DEL', session_key, session_key .. ':links')
  -- For the worker's heartbeats: ended, not lost.
  redis.call('SET', session_key .. ':ended', '1', 'EX', 60)
  return 1
end

if ARGV[1] == 'session' then return finish(ARGV[2]) end

if ARGV[1] == 'browser' then
  -- place.lua gives this browser no ticket from now on. A request that is still under way is over long before this key expires.
  redis.call('SET', 'diaphane:browser:' .. ARGV[2] .. ':ended', '1', 'EX', 60)
  local ended = 0
  for _, session in ipairs(redis.call('ZRANGE', 'diaphane:user:' .. ARGV[3] .. ':sessions', 0, -1)) do
    -- A session without the field was written again by its worker after Redis had lost it. It may be this browser's.
    local browsers = redis.call('HGET', 'diaphane:session:' .. session, 'browsers')
    if not browsers or string.find(browsers, ',' .. ARGV[2] .. ',', 1, true) then ended = ended + finish(session) end
  end
  return ended
end

local all_key = 'diaphane:' .. ARGV[1] .. ':' .. ARGV[2] .. ':sessions'
local ended = 0
for _, session in ipairs(redis.call('ZRANGE', all_key, 0, -1)) do ended = ended + finish(session) end
redis.call('DEL', all_key)
return ended
