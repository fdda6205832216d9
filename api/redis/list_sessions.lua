-- The sessions of a person, oldest first. ARGV: user. Returns {{session, data set, worker}, ...}.
-- Writes nothing but the removal of entries whose session has expired.

local user_key = 'diaphane:user:' .. ARGV[1] .. ':sessions'
local found = {}
for _, session in ipairs(redis.call('ZRANGE', user_key, 0, -1)) do
  local s = redis.call('HMGET', 'diaphane:session:' .. session, 'data_set', 'worker')
  if s[1] then
    found[#found + 1] = {session, s[1], s[2] or ''}
  else
    redis.call('ZREM', user_key, session)
  end
end
return found
