-- A link by which others may join a session (docs/contracts.md, "Redis"). Only the hash of its token is kept.
-- ARGV: session, user, hash of the token, life in s, most links of a session
-- Returns "made" (also of one that is there), "gone" (no such session of this user), "ended" (that one was) or "too_many".

local session_key = keys.session(ARGV[1])
if redis.call('HGET', session_key, 'user') ~= ARGV[2] then return 'gone' end
local links_key = keys.session_links(ARGV[1])
for _, hash in ipairs(redis.call('SMEMBERS', links_key)) do
  if redis.call('EXISTS', keys.link(hash)) == 0 then redis.call('SREM', links_key, hash) end
end
if redis.call('EXISTS', keys.link_ended(ARGV[3])) == 1 then return 'ended' end
if redis.call('SISMEMBER', links_key, ARGV[3]) == 1 then return 'made' end
if redis.call('SCARD', links_key) >= tonumber(ARGV[5]) then return 'too_many' end
redis.call('SET', keys.link(ARGV[3]), ARGV[1], 'EX', ARGV[4])
redis.call('SADD', links_key, ARGV[3])
redis.call('EXPIRE', links_key, kSessionS)
return 'made'
