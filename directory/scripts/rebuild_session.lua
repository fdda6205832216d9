-- Restores a session that Redis has lost (because it restarted empty). Called by the worker that has it.
-- ARGV: 1 session, 2 user, 3 data set, 4 worker, 5 incarnation, 6 placement, 7 scene, 8 input_seq, 9 width, 10 height,
--       11 presenter, 12 whether guests may see slices (1 or 0), 13 "1" for a visitor's session, 14 the data set over it
--       or empty, 15 its motion, then the hashes of the guests' links, each followed by " slices" if it allows all slices
-- Returns 1 if it was written, or 0 if it exists or was ended.
local session_key, links_key = keys.session(ARGV[1]), keys.session_links(ARGV[1])
if redis.call('EXISTS', session_key) == 1 or redis.call('EXISTS', keys.session_ended(ARGV[1])) == 1 then return 0 end
local now = now_ms()
redis.call('HSET', session_key, 'user', ARGV[2], 'data_set', ARGV[3], 'worker', ARGV[4], 'incarnation', ARGV[5],
  'placement', ARGV[6], 'scene', ARGV[7], 'input_seq', ARGV[8], 'width', ARGV[9], 'height', ARGV[10],
  'presenter', ARGV[11], 'guest_slices', ARGV[12], 'opened', now, 'visitor', ARGV[13])
redis.call('EXPIRE', session_key, kSessionS)
local indexes = {keys.user_sessions(ARGV[2]), keys.data_set_sessions(ARGV[3])}
if ARGV[14] ~= '' then
  redis.call('HSET', session_key, 'over', ARGV[14], 'to_first', ARGV[15])
  indexes[3] = keys.data_set_sessions(ARGV[14])
end
for _, key in ipairs(indexes) do
  redis.call('ZADD', key, now, ARGV[1])
  redis.call('EXPIRE', key, kSessionS)
end
for i = 16, #ARGV do
  local hash, permission = string.match(ARGV[i], '^(%S+)(.*)$')
  if redis.call('EXISTS', keys.link_ended(hash)) == 0 then
    redis.call('SET', keys.link(hash), ARGV[1] .. permission, 'EX', kLinkS)
    redis.call('SADD', links_key, hash)
    redis.call('EXPIRE', links_key, kSessionS)
  end
end
return 1
