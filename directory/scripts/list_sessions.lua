-- Lists the sessions of a user or of a data set, oldest first.
-- ARGV: "user" or "data_set", id. Returns {{session, user, data set, worker, charged to, over}, ...}.
-- A session that is only charged to a user is not theirs, so it is not in their list.
-- Writes nothing except to remove entries of expired sessions.

local sessions_key = keys.sessions_of(ARGV[1], ARGV[2])
local found = {}
for _, session in ipairs(redis.call('ZRANGE', sessions_key, 0, -1)) do
  local s = redis.call('HMGET', keys.session(session), 'user', 'data_set', 'worker', 'charged_to', 'over')
  if s[1] and ARGV[1] == 'user' and s[1] ~= ARGV[2] then
    -- It belongs to somebody else.
  elseif s[1] then
    found[#found + 1] = {session, s[1], s[2], s[3] or '', s[4] or '', s[5] or ''}
  else
    redis.call('ZREM', sessions_key, session)
  end
end
return found
