-- Creates a link with which others can join a session (docs/contracts.md, "Redis"). Stores only the hash of its token.
-- ARGV: session, user, hash of the token, lifetime in s, maximum links per session,
--       "1" if guests with this link may get all slices inside the clip
-- Returns "made" (also if the link exists), "other" (it exists with other permissions), "gone" (no such session of the
-- user), "ended" (it is disabled), "too_many".

local session_key = keys.session(ARGV[1])
if redis.call('HGET', session_key, 'user') ~= ARGV[2] then return 'gone' end
local links_key = keys.session_links(ARGV[1])
for _, hash in ipairs(redis.call('SMEMBERS', links_key)) do
  if redis.call('EXISTS', keys.link(hash)) == 0 then redis.call('SREM', links_key, hash) end
end
if redis.call('EXISTS', keys.link_ended(ARGV[3])) == 1 then return 'ended' end
local target = ARGV[1] .. (ARGV[6] == '1' and ' slices' or '')
if redis.call('SISMEMBER', links_key, ARGV[3]) == 1 then
  return redis.call('GET', keys.link(ARGV[3])) == target and 'made' or 'other'
end
if redis.call('SCARD', links_key) >= tonumber(ARGV[5]) then return 'too_many' end
redis.call('SET', keys.link(ARGV[3]), target, 'EX', ARGV[4])
redis.call('SADD', links_key, ARGV[3])
redis.call('EXPIRE', links_key, kSessionS)
return 'made'
