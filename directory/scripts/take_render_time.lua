-- Returns and removes the rendering time that workers have recorded per user, in milliseconds: {user, ms, ...}.
local spent = redis.call('HGETALL', keys.render_time)
redis.call('DEL', keys.render_time)
return spent
