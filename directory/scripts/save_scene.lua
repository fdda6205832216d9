-- Stores the last scene of a session, so that the successor of a lost worker can continue with it.
-- ARGV: 1 session, 2 placement, 3 scene, 4 input_seq, 5 width, 6 height, 7 presenter,
--       8 whether guests may see slices: 1 or 0
-- Returns 1 if it was written, or 0 if the session has ended or has a newer placement, whose scene stays.
local session_key = keys.session(ARGV[1])
local placement = redis.call('HGET', session_key, 'placement')
if not placement or tonumber(placement) ~= tonumber(ARGV[2]) then return 0 end
redis.call('HSET', session_key, 'scene', ARGV[3], 'input_seq', ARGV[4], 'width', ARGV[5], 'height', ARGV[6],
  'presenter', ARGV[7], 'guest_slices', ARGV[8])
redis.call('EXPIRE', session_key, kSessionS)
return 1
