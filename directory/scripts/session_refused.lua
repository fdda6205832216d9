-- A worker had no memory for a session: the place that was kept for it there is given back, and for a while it is placed on
-- others. ARGV: session, worker, placement, ms. Returns 1, or 0 when the session has gone or was placed anew since.

local session, worker, refused_ms = ARGV[1], ARGV[2], tonumber(ARGV[4])
local session_key = keys.session(session)
local known = redis.call('HMGET', session_key, 'worker', 'placement')
if known[1] ~= worker or known[2] ~= ARGV[3] then return 0 end

local now = now_ms()
redis.call('ZREM', keys.worker_sessions(worker), session)
redis.call('ZADD', keys.session_refused(session), now + refused_ms, worker)
redis.call('PEXPIRE', keys.session_refused(session), refused_ms)
return 1
