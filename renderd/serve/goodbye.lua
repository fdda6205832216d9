-- A worker that ends in order takes itself off the list, so that nobody waits for its heartbeat to expire.
-- KEYS: 1 set of workers, 2 hash of this worker, 3 sorted set of its sessions.  ARGV: 1 worker id, 2 incarnation
if redis.call('HGET', KEYS[2], 'incarnation') ~= ARGV[2] then return 0 end
redis.call('DEL', KEYS[2], KEYS[3])
redis.call('SREM', KEYS[1], ARGV[1])
return 1
