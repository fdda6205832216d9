-- Keeps the last scene of a session, so that a lost worker's successor goes on with it.
-- KEYS: 1 hash of the session.  ARGV: 1 placement, 2 scene, 3 input_seq, 4 width, 5 height, 6 presenter,
--       7 whether guests may have slices: 1 or 0
-- 1: written. 0: the session is gone, or was placed anew, and the newer worker's scene stays.
local placement = redis.call('HGET', KEYS[1], 'placement')
if not placement or tonumber(placement) ~= tonumber(ARGV[1]) then return 0 end
redis.call('HSET', KEYS[1], 'scene', ARGV[2], 'input_seq', ARGV[3], 'width', ARGV[4], 'height', ARGV[5],
  'presenter', ARGV[6], 'guest_slices', ARGV[7])
redis.call('EXPIRE', KEYS[1], 86400)
return 1
