-- A session that Redis has lost (it was restarted empty) is written again by the worker that has it.
-- KEYS: 1 hash of the session, 2 set of its links, 3 sessions of its user, 4 sessions of its data set
-- ARGV: 1 session, 2 user, 3 data set, 4 worker, 5 incarnation, 6 placement, 7 scene, 8 input_seq, 9 width, 10 height,
--       11 presenter, 12 whether guests may have slices (1 or 0), 13 prefix of a link's key, 14 life of a link in s, 15 "1" of a visitor's session, then the
--       hashes of links that guests came by
-- 1: written. 0: it is there, or was ended.
if redis.call('EXISTS', KEYS[1]) == 1 or redis.call('EXISTS', KEYS[1] .. ':ended') == 1 then return 0 end
local clock = redis.call('TIME')
local now = clock[1] * 1000 + math.floor(clock[2] / 1000)
redis.call('HSET', KEYS[1], 'user', ARGV[2], 'data_set', ARGV[3], 'worker', ARGV[4], 'incarnation', ARGV[5],
  'placement', ARGV[6], 'scene', ARGV[7], 'input_seq', ARGV[8], 'width', ARGV[9], 'height', ARGV[10],
  'presenter', ARGV[11], 'guest_slices', ARGV[12], 'opened', now, 'visitor', ARGV[15])
redis.call('EXPIRE', KEYS[1], 86400)
for i = 3, 4 do
  redis.call('ZADD', KEYS[i], now, ARGV[1])
  redis.call('EXPIRE', KEYS[i], 86400)
end
for i = 16, #ARGV do
  local key = ARGV[13] .. ARGV[i]
  if redis.call('EXISTS', key .. ':ended') == 0 then
    redis.call('SET', key, ARGV[1], 'EX', ARGV[14])
    redis.call('SADD', KEYS[2], ARGV[i])
    redis.call('EXPIRE', KEYS[2], 86400)
  end
end
return 1
