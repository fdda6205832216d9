-- The sessions of a person, or those that look at a data set, oldest first.
-- ARGV: "user" or "data_set", id. Returns {{session, user, data set, worker}, ...}.
-- Writes nothing but the removal of entries whose session has expired.

local sessions_key = keys.sessions_of(ARGV[1], ARGV[2])
local found = {}
for _, session in ipairs(redis.call('ZRANGE', sessions_key, 0, -1)) do
  local s = redis.call('HMGET', keys.session(session), 'user', 'data_set', 'worker')
  if s[1] then
    found[#found + 1] = {session, s[1], s[2], s[3] or ''}
  else
    redis.call('ZREM', sessions_key, session)
  end
end
return found
