-- Adds the GPU time used by each user's pictures. `api` collects it into Postgres (docs/contracts.md, "Redis").
-- ARGV: user, milliseconds, ...
for i = 1, #ARGV, 2 do redis.call('HINCRBY', keys.render_time, ARGV[i], ARGV[i + 1]) end
return 1
