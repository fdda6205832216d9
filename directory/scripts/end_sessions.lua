-- Ends sessions and frees their slots immediately. The workers learn of it with their next heartbeat.
--
-- ARGV: "session", "data_set" or "user", id; or "browser", its id, the id of its user. Returns how many sessions ended.

local function finish(session)
  local session_key = keys.session(session)
  local s = redis.call('HMGET', session_key, 'user', 'data_set', 'worker', 'charged_to', 'over')
  if not s[1] then return 0 end
  redis.call('ZREM', keys.user_sessions(s[1]), session)
  if s[4] then redis.call('ZREM', keys.user_sessions(s[4]), session) end
  redis.call('ZREM', keys.data_set_sessions(s[2]), session)
  if s[5] then redis.call('ZREM', keys.data_set_sessions(s[5]), session) end
  if s[3] then redis.call('ZREM', keys.worker_sessions(s[3]), session) end
  for _, hash in ipairs(redis.call('SMEMBERS', keys.session_links(session))) do
    redis.call('DEL', keys.link(hash))
  end
  redis.call('ZREM', keys.visitors, session)
  redis.call('DEL', session_key, keys.session_links(session))
  -- Tells the worker's heartbeats that the session was ended and not lost.
  redis.call('SET', keys.session_ended(session), '1', 'EX', kEndedS)
  return 1
end

if ARGV[1] == 'session' then return finish(ARGV[2]) end

if ARGV[1] == 'browser' then
  -- From now on, place.lua issues no ticket to this browser. Requests in progress finish long before this key expires.
  redis.call('SET', keys.browser_ended(ARGV[2]), '1', 'EX', kEndedS)
  local ended = 0
  for _, session in ipairs(redis.call('ZRANGE', keys.user_sessions(ARGV[3]), 0, -1)) do
    -- If the field is missing, the worker restored the session after Redis had lost it. It may belong to this browser.
    local s = redis.call('HMGET', keys.session(session), 'browsers', 'charged_to')
    local browsers = s[1]
    -- A session that is only charged to the user belongs to a browser of somebody else.
    if not s[2] and (not browsers or string.find(browsers, ',' .. ARGV[2] .. ',', 1, true)) then
      ended = ended + finish(session)
    end
  end
  return ended
end

local all_key = keys.sessions_of(ARGV[1], ARGV[2])
local ended = 0
for _, session in ipairs(redis.call('ZRANGE', all_key, 0, -1)) do ended = ended + finish(session) end
redis.call('DEL', all_key)
return ended
