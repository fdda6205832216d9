-- Releases the slot of a session for which the worker had no memory. For a while, the session is placed on other workers.
-- ARGV: session, worker, placement, ms. Returns 1, or 0 if the session has ended or has a newer placement.

local session, worker, refused_ms = ARGV[1], ARGV[2], tonumber(ARGV[4])
local session_key = keys.session(session)
local known = redis.call('HMGET', session_key, 'worker', 'placement')
if known[1] ~= worker or known[2] ~= ARGV[3] then return 0 end

local now = now_ms()
redis.call('ZREM', keys.worker_sessions(worker), session)
redis.call('ZADD', keys.session_refused(session), now + refused_ms, worker)
redis.call('PEXPIRE', keys.session_refused(session), refused_ms)
return 1
