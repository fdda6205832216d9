-- What workers have noted for each person since the last time, in milliseconds: {user, ms, ...}. It is gone from here then.
local spent = redis.call('HGETALL', keys.render_time)
redis.call('DEL', keys.render_time)
return spent
