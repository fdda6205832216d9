-- Removes a worker that cannot be reached, so that the next placement does not wait for its heartbeat to expire.
-- Applies only to this incarnation: a worker that has restarted stays. ARGV: worker, incarnation. Returns 0 or 1.

local worker_key = keys.worker(ARGV[1])
if redis.call('HGET', worker_key, 'incarnation') ~= ARGV[2] then return 0 end
redis.call('DEL', worker_key, keys.worker_sessions(ARGV[1]))
redis.call('SREM', keys.workers, ARGV[1])
return 1
