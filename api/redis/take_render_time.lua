-- What workers have noted for each person since the last time, in milliseconds: {user, ms, ...}. It is gone from here then.
local spent = redis.call('HGETALL', 'diaphane:render_time')
redis.call('DEL', 'diaphane:render_time')
return spent
