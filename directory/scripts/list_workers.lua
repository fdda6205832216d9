-- Lists the live workers. ARGV: protocol epoch.
-- Returns {{worker, address, incarnation, slots, used, draining, volumes, engine, device, load}, ...}.

local found = {}
for _, worker in ipairs(redis.call('SMEMBERS', keys.workers)) do
  local w = redis.call('HMGET', keys.worker(worker),
                       'address', 'incarnation', 'slots', 'used', 'volumes', 'epoch', 'draining', 'engine',
                       'device', 'load')
  if not w[1] then
    redis.call('SREM', keys.workers, worker)
  elseif w[6] == ARGV[1] then
    found[#found + 1] = {worker, w[1], w[2] or '', w[3] or '0', w[4] or '0', w[7] or '0', w[5] or '',
                         w[8] or '', w[9] or '', w[10] or '0'}
  end
end
return found
