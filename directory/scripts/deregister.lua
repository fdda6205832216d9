-- Removes a worker that shuts down normally, so that no session waits for its heartbeat to expire.
-- ARGV: 1 worker id, 2 incarnation
if redis.call('HGET', keys.worker(ARGV[1]), 'incarnation') ~= ARGV[2] then return 0 end
redis.call('DEL', keys.worker(ARGV[1]), keys.worker_sessions(ARGV[1]))
redis.call('SREM', keys.workers, ARGV[1])
return 1
